"""One flight from end to end: take off, go to the start, settle, track, and hand back."""

import asyncio
import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import partial
from typing import TypeAlias

from companion import clock
from companion.arrays import Vec3
from companion.autopilot import Autopilot
from companion.autopilot.position_loop import PositionLoop
from companion.errors import FlightError, GapError, ImpromptuError, LinkError, NoReplyError, TakenError
from companion.flight.approach import joining, rest_at, rest_to_rest
from companion.flight.control import Control, ControlSettings
from companion.flight.guard import Clip
from companion.flight.plan import After, FlightOutcome, FlightPlan
from companion.flight.recorder import FlightRecorder, Recorder
from companion.flight.states import Event, FlightState, next_state
from companion.flight.strategies import position_velocity
from companion.flight.stream import SetpointStream
from companion.flight.takeoff import Announce, home_of, is_flying, take_off
from companion.flight.tracker import Tracker, tracking_error_m
from companion.flight.watchdogs import Action, Alarm, Readings, WatchdogError
from companion.flight.watching import keep_watch, leave_to_taker, of_vehicle, with_stream
from companion.link.status import Landed
from companion.link.tasks import background_tasks
from companion.link.telemetry import Telemetry
from companion.recording.metrics import ErrorSum, TrackingAccuracy
from companion.recording.series import Provenance
from companion.recording.topics import Level
from companion.state import VehicleState
from companion.trajectory.trajectory import Trajectory

__all__ = ["After", "FlightOutcome", "FlightPlan", "fly"]

ShowProgress: TypeAlias = Callable[[float, float], None]
"""Called twice a second with the share of the trajectory that is done and the distance from it (m)."""

ShowState: TypeAlias = Callable[[FlightState], None]

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
_LEAST_MEASURED_S = 0.5 * _LAST_TELEMETRY_S
"""Of a trajectory that is joined at its very end, too."""


async def fly(
    plan: FlightPlan,
    autopilot: Autopilot,
    telemetry: Telemetry,
    *,
    provenance: Provenance,
    recorder: Recorder | None = None,
    announce: Announce = lambda text: None,
    progress: ShowProgress = lambda share, error_m: None,
    on_state: ShowState = lambda state: None,
    temperature_c: Callable[[], float] = lambda: math.nan,
) -> FlightOutcome:
    """Fly `plan`; whatever ends it, the vehicle is left as the plan says, in a hold, or with who took it.

    Args:
        plan: what to fly.
        autopilot: what flies it.
        telemetry: of the same vehicle.
        provenance: what the recording belongs to.
        recorder: to be filled; whoever gives one still has it when the flight fails.
        announce: told each phase as it begins.
        progress: told while the trajectory is tracked.
        on_state: told each state that the flight comes to.
        temperature_c: of the companion's processor (°C); NaN where it is not known.

    Raises:
        FlightError: there is nothing to resume, or nobody asked to resume what was cut off in the air.
        RefusedError: the vehicle refused to arm, take off or be guided.
        TrackingError: the guard ended the flight, or, as `WatchdogError`, a watchdog.
        TakenError: the vehicle changed its mode unasked.
        GapError: setpoints stopped for so long that the vehicle's failsafe has acted.
        LinkError: the vehicle fell silent, or, as `NoReplyError`, left a request unanswered.
    """
    flight = _Flight(
        plan, autopilot, telemetry, recorder or FlightRecorder(), announce, progress, on_state, temperature_c
    )
    unsubscribe = telemetry.subscribe(flight.recorder.state)
    try:
        tracked = await flight.run()
        await flight.hand_back()
    except (TakenError, GapError) as left:
        flight.recorder.event(clock.now(), str(left), level=Level.WARNING)
        flight.came(Event.TAKE if isinstance(left, TakenError) else Event.FAIL)
        raise
    except BaseException as trouble:
        flight.recorder.event(clock.now(), str(trouble) or "stopped", level=Level.ERROR)
        await flight.leave(trouble)
        raise
    finally:
        unsubscribe()
    recording = flight.recorder.recording(provenance)
    return FlightOutcome(tracked.accuracy, tracked.trajectory, tracked.start_s, tracked.clips, recording)


@dataclass(frozen=True, eq=False)
class _Tracked:
    """A trajectory that was tracked to its end.

    Attributes:
        trajectory: NED of the vehicle's origin (m).
        start_s: when it began, or would have (companion clock, s).
        accuracy: against the vehicle's own estimate.
        clips: how often the guard changed what.
    """

    trajectory: Trajectory
    start_s: float
    accuracy: TrackingAccuracy
    clips: Mapping[Clip, int]


@dataclass(eq=False)
class _Flight:
    """A flight under way, its phases as methods; `found_in` is the mode of a vehicle found flying."""

    plan: FlightPlan
    autopilot: Autopilot
    telemetry: Telemetry
    recorder: Recorder
    announce: Announce
    progress: ShowProgress
    on_state: ShowState
    temperature_c: Callable[[], float]
    found_in: str = ""
    state: FlightState = FlightState.DISCONNECTED

    def came(self, event: Event) -> None:
        """Something happened that may lead to another state."""
        state = next_state(self.state, event)
        if state is not self.state:
            said = {"from": self.state, "to": state, "event": event}
            self.recorder.event(clock.now(), f"state: {state} ({event})", "state", said)
            self.state = state
            self.on_state(state)

    def note(self, text: str) -> None:
        """A phase begins, or something is worth telling."""
        self.recorder.event(clock.now(), text)
        self.announce(text)

    async def run(self) -> _Tracked:
        """From wherever the vehicle is to the end of the trajectory, and into a hold."""
        timeout_s = await self.autopilot.setpoint_timeout_s()
        if self.plan.correction is not None:
            self.plan.correction.loop = await self._position_loop()
        home = await self._into_the_air()
        state = await self.telemetry.next_state()
        control = Control(
            self._settings(home, state),
            Tracker(rest_at(state.position), clock.now()),
            self.recorder,
            self.announce,
        )
        stream = SetpointStream(
            self.autopilot,
            self.telemetry,
            control,
            period_s=self.plan.period_s,
            state_age=self.plan.limits.watchdogs.state_age_s,
            timeout_s=timeout_s,
        )
        trajectory = self.plan.trajectory.moved(home)
        begin = self._join if self.plan.resume else self._begin
        async with background_tasks() as spawn:
            spawn(stream.run())
            await self.autopilot.engage()
            self.came(Event.GUIDE)
            spawn(leave_to_taker(self.autopilot))
            spawn(
                keep_watch(
                    self.plan.limits.watchdogs,
                    lambda now_s: with_stream(self._readings(now_s), stream),
                    partial(self._fall_back, stream),
                )
            )
            tracker, from_s = await begin(trajectory, stream)
            self.came(Event.TRACK)
            accuracy = await self._measure(tracker, from_s)
            self.note("holding")
            await self.autopilot.hold()
            self.came(Event.HOLD)
        return _Tracked(trajectory, tracker.start_s, accuracy, control.clips)

    async def hand_back(self) -> None:
        """As the plan says, after the hold."""
        match self.plan.after:
            case After.LAND:
                await self._land()
            case After.RETURN:
                await self._return()

    async def leave(self, trouble: BaseException) -> None:
        """After trouble: in a hold, unless a watchdog says otherwise or the vehicle was left landing."""
        if self.state is FlightState.LANDING and isinstance(trouble, LinkError):
            self.note("the vehicle is left to its landing")
            self.came(Event.LOSE)
            return
        try:
            match trouble.action if isinstance(trouble, WatchdogError) else Action.HOLD:
                case Action.LAND:
                    await self._land()
                case Action.RETURN:
                    await self._return()
                case Action.YIELD:
                    self.note("nothing more is sent: the vehicle is left to its pilot or its failsafe")
                    self.came(Event.FAIL)
                case _:
                    await self.leave_in_a_hold()
        except TakenError as taken:
            self.note(str(taken))
            self.came(Event.TAKE)
        except ImpromptuError as error:
            self.note(f"that failed: {error}")
            await self.leave_in_a_hold()

    async def _land(self) -> None:
        self.note("landing")
        self.came(Event.LAND)
        await self.autopilot.land()
        self.came(Event.GROUND)

    async def _return(self) -> None:
        self.note("returning to where it took off")
        self.came(Event.LAND)
        await self.autopilot.return_home()
        self.came(Event.GROUND)

    def _readings(self, now_s: float) -> Readings:
        return of_vehicle(self.telemetry.status, self.temperature_c(), now_s)

    def _climb_readings(self, now_s: float) -> Readings:
        """Nothing before it has left the ground."""
        is_down = self.telemetry.status.landed is Landed.ON_GROUND
        return Readings() if is_down else self._readings(now_s)

    def _fall_back(self, stream: SetpointStream | None, alarm: Alarm) -> None:
        """Track with nothing but the plain strategy from now on."""
        if self.plan.is_plain:
            return
        self.note(f"falling back on the plain strategy: {alarm}")
        self.plan = replace(self.plan, law=position_velocity, correction=None, supervision=None)
        if stream is not None:
            stream.fall_back()

    async def leave_in_a_hold(self) -> None:
        """Leave a vehicle that may be flying in a hold, if it still listens to us and ever did."""
        as_found = self.autopilot.mode == self.found_in and not self.autopilot.engaged
        if self.autopilot.taken:
            self.came(Event.TAKE)
            return
        if not self.telemetry.status.armed:
            self.came(Event.GROUND)
        if as_found or not self.telemetry.status.armed:
            return
        self.note("telling the vehicle to hold")
        try:
            async with asyncio.timeout(_HAND_OVER_S):
                await self.autopilot.hold()
            self.came(Event.HOLD)
            self.note("the vehicle holds")
        except (ImpromptuError, TimeoutError) as error:
            self.note(f"could not be told to hold ({error}): without setpoints its own failsafe acts")
            self.came(Event.LOSE if isinstance(error, LinkError) else Event.FAIL)

    async def _position_loop(self) -> PositionLoop:
        """The autopilot's own, or the usual one of its kind."""
        try:
            return await self.autopilot.position_loop()
        except NoReplyError as unknown:
            self.note(f"{unknown}: its defaults assumed")
            return self.autopilot.usual_position_loop

    def _settings(self, home: Vec3, state: VehicleState) -> ControlSettings:
        """What the control loop is told, the takeoff point being `home` (NED, m)."""
        loop = None if self.plan.correction is None else self.plan.correction.loop
        return ControlSettings(
            home=home.tolist(),
            yaw=float(state.attitude[2]),
            yaw_mode=self.plan.yaw,
            period_s=self.plan.period_s,
            limits=self.plan.limits,
            vehicle_fence=self.plan.vehicle_fence,
            stiffness_1_s2=None if loop is None else loop.stiffness_1_s2.tolist(),
            damping_1_s=None if loop is None else loop.damping_1_s.tolist(),
        )

    async def _into_the_air(self) -> Vec3:
        """The vehicle's takeoff point (NED, m)."""
        flies = await is_flying(self.telemetry, self.note)
        self.came(Event.CONNECT)
        if not flies:
            if self.plan.resume:
                raise FlightError("the vehicle is on the ground, so there is nothing to resume: fly anew")
            self.came(Event.TAKE_OFF)
            _, ceiling_m = self.plan.limits.fence.altitude_m
            return await self._take_off(min(self.plan.takeoff_altitude_m, ceiling_m))
        self.came(Event.FIND_FLYING)
        self.found_in = self.autopilot.mode
        if self.plan.cut_off and not self.plan.resume:
            raise FlightError(
                f"the vehicle is in the air, armed, in {self.found_in}: {self.plan.cut_off} was cut off "
                "there. Nothing was sent: --resume takes it over and goes on at the nearest point"
            )
        action = "resuming where it is" if self.plan.resume else "going to the start from there"
        self.note(f"already in the air, in {self.found_in}: {action}")
        return await home_of(self.telemetry, self.note)

    async def _take_off(self, altitude_m: float) -> Vec3:
        """Climb, watched; the takeoff point (NED, m)."""
        async with background_tasks() as spawn:
            watchdogs = self.plan.limits.watchdogs
            spawn(keep_watch(watchdogs, self._climb_readings, partial(self._fall_back, None)))
            return await take_off(self.autopilot, self.telemetry, altitude_m, self.note)

    async def _begin(self, trajectory: Trajectory, stream: SetpointStream) -> tuple[Tracker, float]:
        """Go to the start and settle there, the strategy active; what tracks then, and since when (s)."""
        state = stream.control.newest or await self.telemetry.next_state()
        start = trajectory.at(0.0).position
        approach = Tracker(rest_to_rest(state.position, start), clock.now())
        self.note("going to the start")
        stream.follow(approach)
        await clock.sleep_until(approach.end_s)
        self.note("settling")
        stream.follow(self._tracker(rest_at(start), clock.now()))
        await _settle(start, self.plan.settle_s, self.telemetry)
        tracker = self._tracker(trajectory, clock.now() + _LEAD_S)
        stream.follow(tracker)
        await clock.sleep_until(tracker.start_s)
        return tracker, tracker.start_s

    async def _join(self, trajectory: Trajectory, stream: SetpointStream) -> tuple[Tracker, float]:
        """Speed up onto the trajectory where it is nearest; what tracks it, and since when (s)."""
        state = stream.control.newest or await self.telemetry.next_state()
        way, joins_s = joining(state.position, trajectory)
        self.note(f"resuming {trajectory.name} at {joins_s:.1f} s")
        joining_tracker = self._tracker(way, clock.now())
        stream.follow(joining_tracker)
        await clock.sleep_until(joining_tracker.end_s)
        tracker = self._tracker(trajectory, joining_tracker.end_s - joins_s)
        stream.follow(tracker)
        return tracker, joining_tracker.end_s

    def _tracker(self, trajectory: Trajectory, start_s: float) -> Tracker:
        return Tracker(trajectory, start_s, self.plan.law, self.plan.correction, self.plan.supervision)

    async def _measure(self, tracker: Tracker, from_s: float) -> TrackingAccuracy:
        """Track to the end; how closely that was done from `from_s` (companion clock, s) on."""
        trajectory, to_s = tracker.trajectory, max(tracker.end_s, from_s + _LEAST_MEASURED_S)
        errors = ErrorSum(lambda time_s: trajectory.at(time_s - tracker.start_s).position, from_s, to_s)
        if (first := self.telemetry.state) is not None:  # it may be of the first instant
            errors.add(first.time_s, first.position)
        unsubscribe = self.telemetry.subscribe(lambda state: errors.add(state.time_s, state.position))
        try:
            await self._track(tracker)
        finally:
            unsubscribe()
        return errors.accuracy

    async def _track(self, tracker: Tracker) -> None:
        """Tell how far the vehicle is, until the trajectory and its last telemetry are over."""
        trajectory = tracker.trajectory
        self.note(f"tracking {trajectory.name} for {tracker.end_s - clock.now():.1f} s")
        while (now_s := clock.now()) < tracker.end_s:
            state = self.telemetry.state
            if state is not None:
                error_m = tracking_error_m(state, trajectory.at(state.time_s - tracker.start_s))
                self.progress((now_s - tracker.start_s) / trajectory.duration_s, error_m)
            await clock.sleep_until(min(now_s + _PROGRESS_S, tracker.end_s))
        await asyncio.sleep(_LAST_TELEMETRY_S)


async def _settle(start: Vec3, at_least_s: float, telemetry: Telemetry) -> None:
    """Wait until the vehicle is where it starts from: in wind, integrators take their time."""
    earliest_s, latest_s = clock.now() + at_least_s, clock.now() + at_least_s + _SETTLED_WITHIN_S
    while (now_s := clock.now()) < latest_s:
        is_there = telemetry.state is not None and math.dist(telemetry.state.position, start) < _SETTLED_M
        if is_there and now_s >= earliest_s:
            return
        await asyncio.sleep(_POLL_S)
