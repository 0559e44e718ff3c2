"""One flight from end to end: take off, go to the start, settle, track, and hold or land."""

import asyncio
import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import TypeAlias

import numpy as np

from companion import clock
from companion.arrays import Vec3
from companion.autopilot import Autopilot
from companion.errors import FlightError, ImpromptuError, RefusedError, TakenError
from companion.flight.approach import rest_at, rest_to_rest
from companion.flight.guard import Clip, GuardLimits
from companion.flight.online_correction import OnlineCorrection
from companion.flight.recorder import FlightRecorder
from companion.flight.strategies import ReferenceLaw, position_velocity
from companion.flight.stream import SetpointStream
from companion.flight.tracker import Tracker, tracking_error_m
from companion.link.status import Landed
from companion.link.tasks import background_tasks
from companion.link.telemetry import Telemetry
from companion.recording.metrics import TrackingAccuracy, tracking_accuracy
from companion.recording.series import Provenance, Recording
from companion.trajectory.trajectory import Trajectory

Announce: TypeAlias = Callable[[str], None]
ShowProgress: TypeAlias = Callable[[float, float], None]
"""Called twice a second with the share of the trajectory that is done and the distance from it (m)."""

_READY_WITHIN_S = 60.0
"""How long a vehicle that was just switched on may take until it can be armed."""
_ASK_AGAIN_S = 1.0
_TELLS_WITHIN_S = 3.0
_POLL_S = 0.05
_PROGRESS_S = 0.5
_HAND_OVER_S = 5.0
"""How long handing over may take when a flight ends in trouble."""
_SETTLED_M = 0.1
"""This near to the start the vehicle is there."""
_SETTLED_WITHIN_S = 7.0
"""If it does not get there, the flight begins all the same: its error is part of what is measured."""
_LEAD_S = 0.5
"""From settled to the first instant of the trajectory, in which previews begin to see it."""
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
        settle_s: least time at rest at the start, the strategy already active (s).
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
    recorder: FlightRecorder | None = None,
    announce: Announce = lambda text: None,
    progress: ShowProgress = lambda share, error_m: None,
) -> FlightOutcome:
    """Fly `plan`; whatever ends it, the vehicle is left in a hold (or landed), or with who took it.

    Args:
        plan: what to fly.
        autopilot: what flies it.
        telemetry: of the same vehicle.
        provenance: what the recording belongs to.
        recorder: to be filled; whoever gives one still has it when the flight fails.
        announce: told each phase as it begins.
        progress: told while the trajectory is tracked.

    Raises:
        RefusedError: the vehicle refused to arm, take off or be guided.
        TrackingError: the guard ended the flight.
        TakenError: the vehicle changed its mode unasked.
        LinkError: the vehicle fell silent.
    """
    recorder = FlightRecorder() if recorder is None else recorder

    def note(text: str) -> None:
        recorder.event(clock.now(), text)
        announce(text)

    unsubscribe = telemetry.subscribe(recorder.state)
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
            start_s = await _track(plan, trajectory, stream, telemetry, note, progress)
            note("holding")
            await autopilot.hold()
        if plan.land:
            note("landing")
            await autopilot.land()
    except TakenError as taken:
        recorder.event(clock.now(), str(taken))
        raise
    except BaseException as trouble:
        recorder.event(clock.now(), str(trouble) or "stopped")
        await _hand_over(autopilot, telemetry, note)
        raise
    finally:
        unsubscribe()
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
    if telemetry.state is None:
        note("waiting until the vehicle knows its position")
    state = await telemetry.next_state(_READY_WITHIN_S)
    if not await _until(lambda: telemetry.status.landed is not Landed.UNDEFINED):
        raise FlightError("the vehicle does not tell whether it flies: have it send EXTENDED_SYS_STATE")
    if telemetry.status.landed is not Landed.ON_GROUND:
        note("already in the air")
        await _until(lambda: telemetry.status.home is not None)
        if telemetry.status.home is None:
            note("the vehicle tells no home position: the origin of its own map stands in")
        return np.zeros(3) if telemetry.status.home is None else telemetry.status.home
    note("arming")
    await _arm(autopilot, note)
    note(f"taking off to {plan.takeoff_altitude_m:g} m")
    await autopilot.takeoff(plan.takeoff_altitude_m)
    return state.position


async def _arm(autopilot: Autopilot, note: Announce) -> None:
    """Arm, asking again while the vehicle is still getting ready, and telling why it is not."""
    give_up_s = clock.now() + _READY_WITHIN_S
    told = ""
    while True:
        try:
            return await autopilot.arm()
        except RefusedError as refusal:
            if clock.now() >= give_up_s:
                raise
            if str(refusal) != told:
                told = str(refusal)
                note(f"not ready, trying for up to {_READY_WITHIN_S:g} s: {told}")
        await asyncio.sleep(_ASK_AGAIN_S)


async def _until(condition: Callable[[], bool]) -> bool:
    """Wait a little for what the vehicle tells now and then; whether it did."""
    give_up_s = clock.now() + _TELLS_WITHIN_S
    while clock.now() < give_up_s:
        if condition():
            return True
        await asyncio.sleep(_POLL_S)
    return condition()


async def _track(
    plan: FlightPlan,
    trajectory: Trajectory,
    stream: SetpointStream,
    telemetry: Telemetry,
    note: Announce,
    progress: ShowProgress,
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
    start = trajectory.at(0.0).position
    stream.follow(Tracker(rest_at(start), clock.now(), plan.law, plan.correction))
    await _settle(start, plan.settle_s, telemetry)
    tracker = Tracker(trajectory, clock.now() + _LEAD_S, plan.law, plan.correction)
    stream.follow(tracker)
    await clock.sleep_until(tracker.start_s)
    note(f"tracking {trajectory.name} for {trajectory.duration_s:.1f} s")
    while (now_s := clock.now()) < tracker.end_s:
        if telemetry.state is not None:
            error_m = tracking_error_m(
                telemetry.state, trajectory.at(telemetry.state.time_s - tracker.start_s)
            )
            progress((now_s - tracker.start_s) / trajectory.duration_s, error_m)
        await clock.sleep_until(min(now_s + _PROGRESS_S, tracker.end_s))
    await asyncio.sleep(_LAST_TELEMETRY_S)
    return tracker.start_s


async def _settle(start: Vec3, at_least_s: float, telemetry: Telemetry) -> None:
    """Wait until the vehicle is where it starts from: in wind, integrators take their time."""
    earliest_s, latest_s = clock.now() + at_least_s, clock.now() + at_least_s + _SETTLED_WITHIN_S
    while (now_s := clock.now()) < latest_s:
        is_there = telemetry.state is not None and math.dist(telemetry.state.position, start) < _SETTLED_M
        if is_there and now_s >= earliest_s:
            return
        await asyncio.sleep(_POLL_S)


async def _until_taken(autopilot: Autopilot) -> None:
    mode = await autopilot.until_taken()
    raise TakenError(f"the vehicle went to {mode} unasked: it was left to whoever did that")


async def _hand_over(autopilot: Autopilot, telemetry: Telemetry, note: Announce) -> None:
    """Leave a vehicle that may be flying in a hold, if it still listens to us."""
    if not telemetry.status.armed:
        return
    note("telling the vehicle to hold")
    try:
        async with asyncio.timeout(_HAND_OVER_S):
            await autopilot.hold()
        note("the vehicle holds")
    except (ImpromptuError, TimeoutError) as error:
        note(f"could not be told to hold ({error}): without setpoints its own failsafe acts")
