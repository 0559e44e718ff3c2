"""One flight from end to end: take off, go to the start, settle, track, and hold or land."""

import asyncio
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

import numpy as np

from companion import clock
from companion.arrays import Vec3
from companion.autopilot import Autopilot
from companion.errors import ImpromptuError, TakenError
from companion.flight.approach import rest_at, rest_to_rest
from companion.flight.guard import Clip, GuardLimits
from companion.flight.online_correction import OnlineCorrection
from companion.flight.recorder import FlightRecorder
from companion.flight.strategies import ReferenceLaw, position_velocity
from companion.flight.stream import SetpointStream
from companion.flight.tracker import Tracker
from companion.link.status import Landed
from companion.link.tasks import background_tasks
from companion.link.telemetry import Telemetry
from companion.recording.metrics import TrackingAccuracy, tracking_accuracy
from companion.recording.series import Provenance, Recording
from companion.trajectory.trajectory import Trajectory

Announce = Callable[[str], None]

_HAND_OVER_S = 5.0
"""How long handing over may take when a flight ends in trouble."""
_LAST_TELEMETRY_S = 0.5
"""After the last instant, until the states of that instant have arrived."""


@dataclass(frozen=True)
class FlightPlan:
    """What to fly, and how.

    Attributes:
        trajectory: NED relative to the takeoff point (m).
        law: how u1 is made.
        correction: the online module, or None.
        period_s: between two setpoints (s).
        limits: of the guard.
        settle_s: time at rest at the start, the strategy already active (s).
        takeoff_altitude_m: where a vehicle on the ground is first sent, above its takeoff point (m).
        land: land afterwards instead of holding.
    """

    trajectory: Trajectory
    law: ReferenceLaw = position_velocity
    correction: OnlineCorrection | None = None
    period_s: float = 0.02
    limits: GuardLimits = field(default_factory=GuardLimits)
    settle_s: float = 3.0
    takeoff_altitude_m: float = 2.5
    land: bool = False


@dataclass(frozen=True)
class FlightOutcome:
    """What came of a flight.

    Attributes:
        accuracy: against the vehicle's own estimate, which is all that a companion can know.
        trajectory: what was to be flown, NED of the vehicle's origin (m).
        start_s: when it began (companion clock, s).
        clips: how often the guard changed what.
        recording: all of it.
    """

    accuracy: TrackingAccuracy
    trajectory: Trajectory
    start_s: float
    clips: Mapping[Clip, int]
    recording: Recording


async def fly(
    plan: FlightPlan,
    autopilot: Autopilot,
    telemetry: Telemetry,
    *,
    provenance: Provenance,
    announce: Announce = lambda text: None,
) -> FlightOutcome:
    """Fly `plan`; whatever ends it, the vehicle is left in a hold (or landed), or with who took it.

    Raises:
        RefusedError: the vehicle refused to arm, take off or be guided.
        TrackingError: the guard ended the flight.
        TakenError: the vehicle changed its mode unasked.
        LinkError: the vehicle fell silent.
    """
    recorder = FlightRecorder()

    def note(text: str) -> None:
        recorder.event(clock.now(), text)
        announce(text)

    try:
        home = await _take_off(plan, autopilot, telemetry, note)
        state = await telemetry.next_state()
        stream = SetpointStream(
            autopilot,
            telemetry,
            recorder,
            Tracker(rest_at(state.position), clock.now()),
            home=home,
            yaw=float(state.attitude[2]),
            limits=plan.limits,
            period_s=plan.period_s,
        )
        trajectory = plan.trajectory.moved(home)
        async with background_tasks() as spawn:
            spawn(stream.run())
            await autopilot.engage()
            spawn(_until_taken(autopilot))
            start_s = await _track(plan, trajectory, stream, telemetry, note)
            note("landing" if plan.land else "holding")
            await (autopilot.land() if plan.land else autopilot.hold())
    except TakenError as taken:
        note(str(taken))
        raise
    except BaseException:
        await _hand_over(autopilot, note)
        raise
    recording = recorder.recording(provenance)
    accuracy = tracking_accuracy(
        lambda time_s: trajectory.sample(time_s - start_s).position,
        recording.states.time_s,
        recording.states.position,
        start_s,
        start_s + trajectory.duration_s,
    )
    return FlightOutcome(accuracy, trajectory, start_s, stream.clips, recording)


async def _take_off(plan: FlightPlan, autopilot: Autopilot, telemetry: Telemetry, note: Announce) -> Vec3:
    """Get the vehicle into the air unless it is there; its takeoff point (NED, m)."""
    state = await telemetry.next_state()
    status = telemetry.status
    if status.landed is Landed.IN_AIR:
        note("already in the air")
        return np.zeros(3) if status.home is None else status.home
    note("arming")
    await autopilot.arm()
    note(f"taking off to {plan.takeoff_altitude_m:g} m")
    await autopilot.takeoff(plan.takeoff_altitude_m)
    return state.position


async def _track(
    plan: FlightPlan,
    trajectory: Trajectory,
    stream: SetpointStream,
    telemetry: Telemetry,
    note: Announce,
) -> float:
    """Go to the start, settle there with the strategy active, and follow the trajectory to its end.

    Returns:
        When the trajectory began (companion clock, s).
    """
    state = await telemetry.next_state()
    approach = Tracker(rest_to_rest(state.position, trajectory.at(0.0).position), clock.now())
    note("going to the start")
    stream.follow(approach)
    await clock.sleep_until(approach.end_s)
    note("settling")
    tracker = Tracker(trajectory, clock.now() + plan.settle_s, plan.law, plan.correction)
    stream.follow(tracker)
    await clock.sleep_until(tracker.start_s)
    note(f"tracking {trajectory.name} for {trajectory.duration_s:.1f} s")
    await clock.sleep_until(tracker.end_s + _LAST_TELEMETRY_S)
    return tracker.start_s


async def _until_taken(autopilot: Autopilot) -> None:
    mode = await autopilot.until_taken()
    raise TakenError(f"the vehicle went to {mode} unasked: it was left to whoever did that")


async def _hand_over(autopilot: Autopilot, note: Announce) -> None:
    """Leave the vehicle in a hold, if it still listens to us."""
    try:
        async with asyncio.timeout(_HAND_OVER_S):
            await autopilot.hold()
        note("handed over in a hold")
    except (ImpromptuError, TimeoutError) as error:
        note(f"could not be told to hold ({error}): without setpoints its own failsafe acts")
