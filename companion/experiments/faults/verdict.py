"""What is made of a flight in which something failed: how soon it was noticed, what was done, its end."""

from typing import TypeAlias

import numpy as np
from jaxtyping import Bool, Float
from pydantic import BaseModel, ConfigDict

from companion.arrays import Array, Vec3s
from companion.errors import TakenError
from companion.experiments.faults.catalogue import CRASH_M_S, criterion
from companion.experiments.faults.flight import Course, FaultFlight, KilledError, Phase
from companion.flight.watchdogs import Action, WatchdogError
from sitl.firmware.interface import Mode
from sitl.vehicle import load_vehicle

FLY_AWAY_M = 10.0
"""Farther than this from where it should be, a vehicle has flown away."""
_TOUCHED_M = 0.01
_ROUTINE = (
    *("arming", "taking off", "going to", "settling", "tracking", "holding", "landing", "telling"),
    *("state: taking", "state: approaching", "state: tracking", "state: holding", "state: landing"),
    "state: standby",
)
"""How a companion begins what it says in any flight."""
_ENDS = {
    Mode.HOLD: "hold",
    Mode.POSCTL: "hold",
    Mode.BRAKE: "hold",
    Mode.LAND: "land",
    Mode.RTL: "return",
    Mode.OFFBOARD: "stays guided",
}
_HOLDS = (Mode.HOLD, Mode.BRAKE)
"""What a companion asks for; without one PX4 holds in POSCTL."""
_DESCENTS = {Action.LAND: Mode.LAND, Action.RETURN: Mode.RTL}

Mask: TypeAlias = Bool[np.ndarray[tuple[int, ...], np.dtype[np.bool_]], " n"]


class FaultRow(BaseModel):
    """One flight, as the benchmark's file holds it.

    Attributes:
        fault: with its parameters. kind: alone.
        phase: in which it struck.
        vehicle, conditions, seed: of the flight.
        criterion: what can be survived, as written before the flight. survivable: whether this can.
        struck: whether it came to that; a flight that is over before shows nothing.
        detected_s: until companion or autopilot said something of it (s); null if neither ever did.
        detected_by: who did first.
        action: what was done.
        deviation_m: farthest from the desired position, or sideways from the last one (m).
        touchdown_m_s: speed at which it met the ground first; null if it is still in the air.
        breach: whether it left the guard's fence. fly_away: whether it got too far, or went on moving.
        crash: whether it met the ground too fast.
        error: how the companion ended the flight; empty where it came to its end.
    """

    model_config = ConfigDict(frozen=True, extra="forbid")

    fault: str
    kind: str
    phase: Phase
    vehicle: str
    conditions: str
    seed: int
    criterion: str
    survivable: bool
    struck: bool
    detected_s: float | None
    detected_by: str
    action: str
    deviation_m: float
    touchdown_m_s: float | None
    breach: bool
    fly_away: bool
    crash: bool
    error: str

    @property
    def lost(self) -> bool:
        """Whether it ended in a breach, a fly-away or a crash."""
        return self.breach or self.fly_away or self.crash


def judge(flight: FaultFlight, course: Course) -> FaultRow:
    """The row of a flight."""
    scenario, failure = flight.scenario, flight.failure
    written = criterion(failure, load_vehicle(scenario.vehicle))
    struck_s = np.inf if course.struck_s is None else course.struck_s
    after = course.time_s >= struck_s
    detected_s, detected_by = _detection(course, struck_s)
    deviation = np.where(after & ~_is_piloted(course), _deviations_m(course), 0.0)
    touchdown = _touchdown_m_s(course, after)
    return FaultRow(
        fault=failure.name,
        kind=failure.kind,
        phase=flight.phase,
        vehicle=scenario.vehicle,
        conditions=scenario.conditions,
        seed=scenario.seed,
        criterion=written.text,
        survivable=written.survivable,
        struck=course.struck_s is not None,
        detected_s=detected_s,
        detected_by=detected_by,
        action=_action(course),
        deviation_m=float(deviation.max()),
        touchdown_m_s=touchdown,
        breach=bool((after & _outside(course)).any()),
        fly_away=bool(deviation.max() > FLY_AWAY_M) or _drifts_on(course),
        crash=touchdown is not None and touchdown > CRASH_M_S,
        error="" if course.error is None else f"{type(course.error).__name__}: {course.error}",
    )


def _detection(course: Course, struck_s: float) -> tuple[float | None, str]:
    dead = isinstance(course.error, KilledError)
    said = [(at_s, "companion") for at_s, text in course.events if not (dead or text.startswith(_ROUTINE))]
    warned = [(at_s, "autopilot") for at_s, _ in course.warnings]
    first = min(said + warned, default=None)
    return (None, "") if first is None else (max(0.0, first[0] - struck_s), first[1])


def _action(course: Course) -> str:
    """What was done in the end, and by whom unless by the companion."""
    if course.struck_s is None:
        return ""
    last = course.modes[-1][1]
    match course.error:
        case None:
            return "falls back" if _fell_back(course) else "flies on"
        case TakenError():
            return f"yields ({_ENDS.get(last, last.name)})"
        case KilledError():
            return f"autopilot: {_ENDS.get(last, last.name)}"
        case WatchdogError(action=action) if _DESCENTS.get(action) in [mode for _, mode in course.modes]:
            return str(action)  # whatever mode it is in on the ground
    told = any(text.startswith("telling the vehicle to hold") for _, text in course.events)
    done = _ENDS.get(last, last.name)
    return done if told and last in _HOLDS else f"autopilot: {done}"


def _fell_back(course: Course) -> bool:
    return any(text.startswith(("negative transfer", "guard: not finite")) for _, text in course.events)


def _deviations_m(course: Course) -> Float[Array, " n"]:
    """From the desired position while there is one, before and after it sideways alone (m)."""
    if not len(course.desired_s):
        return np.hypot(course.position[:, 0], course.position[:, 1])
    desired = _at(course)
    off = course.position - desired
    wanted = (course.time_s >= course.desired_s[0]) & (course.time_s <= course.desired_s[-1])
    sideways = np.hypot(off[:, 0], off[:, 1])
    homewards = _off_the_way_home(course.position, course.desired[-1])
    deviation = np.where(wanted, np.linalg.norm(off, axis=1), sideways)
    return np.where(_is_in(course, Mode.RTL), homewards, deviation)


def _at(course: Course) -> Vec3s:
    axes = [np.interp(course.time_s, course.desired_s, course.desired[:, axis]) for axis in range(3)]
    return np.stack(axes, axis=1)


def _off_the_way_home(position: Vec3s, start: Float[Array, "3"]) -> Float[Array, " n"]:
    """Distance from the straight way from above `start` to above the takeoff point (m)."""
    way, places = start[:2], position[:, :2]
    length = float(way @ way)
    share = np.clip(places @ way / length, 0.0, 1.0) if length else np.zeros(len(places))
    return np.asarray(np.linalg.norm(places - share[:, None] * way, axis=1))


def _is_in(course: Course, *modes: Mode) -> Mask:
    """When the vehicle was in one of these modes."""
    since_s = np.array([at_s for at_s, _ in course.modes])
    which = np.searchsorted(since_s, course.time_s, side="right") - 1
    return np.array([mode in modes for _, mode in course.modes])[np.maximum(which, 0)]


def _is_piloted(course: Course) -> Mask:
    """From when the vehicle was left to whoever took it; where that is wrong, it is the pilot's business."""
    taken = isinstance(course.error, TakenError) and not course.warnings
    left_s = max((at_s for at_s, _ in course.modes), default=np.inf) if taken else np.inf
    return np.asarray(course.time_s >= left_s)


def _outside(course: Course) -> Mask:
    """Beyond a side or above the ceiling of the fence; below its floor one lands."""
    low, high = course.fence.corners()
    return np.asarray(
        (course.position[:, :2] < low[:2]).any(axis=1)
        | (course.position[:, :2] > high[:2]).any(axis=1)
        | (course.position[:, 2] < low[2])
    )


def _touchdown_m_s(course: Course, after: Mask) -> float | None:
    """Speed just before the ground was met first."""
    high = -course.position[:, 2] > _TOUCHED_M
    met = np.flatnonzero(after[1:] & high[:-1] & ~high[1:])
    return float(np.linalg.norm(course.velocity[met[0]])) if met.size else None


def _drifts_on(course: Course) -> bool:
    """Whether it is still in the air, moves sideways and is nobody's."""
    in_air = -course.position[-1, 2] > _TOUCHED_M
    moves = float(np.hypot(*course.velocity[-1, :2])) > 1.0
    return bool(in_air and moves and not _is_piloted(course)[-1])
