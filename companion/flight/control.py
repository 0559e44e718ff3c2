"""From states to setpoints: tracker, frame, heading and guard in one. No clock, no I/O.

So a flight can be computed again from what it recorded: the same calls in the same order give the same bits.
"""

import math
from collections import Counter
from collections.abc import Callable
from typing import TypeAlias

import numpy as np
from pydantic import BaseModel, ConfigDict

from companion.autopilot.position_loop import PositionLoop
from companion.errors import TrackingError
from companion.flight.continuous_frame import ContinuousFrame
from companion.flight.expectation import Expectation
from companion.flight.guard import Before, Clip, Guarded, GuardLimits, guard
from companion.flight.heading import YawMode, yaw_jump
from companion.flight.recorder import Recorder
from companion.flight.reference import Reference
from companion.flight.tracker import Tracker, tracking_error_m
from companion.flight.vehicle_fence import NO_FENCE, VehicleFence
from companion.state import VehicleState

Triple: TypeAlias = tuple[float, float, float]


class ControlSettings(BaseModel):
    """What a control loop is told when it begins.

    Attributes:
        home: the takeoff point, NED (m).
        yaw: where the nose points then (rad).
        yaw_mode: and afterwards.
        period_s: between two setpoints (s).
        limits: of the guard.
        vehicle_fence: the vehicle's own, from the takeoff point.
        stiffness_1_s2, damping_1_s: the autopilot's own loop (`PositionLoop`), where a correction asked.
    """

    model_config = ConfigDict(frozen=True, extra="forbid")

    home: Triple
    yaw: float
    yaw_mode: YawMode
    period_s: float
    limits: GuardLimits
    vehicle_fence: VehicleFence = NO_FENCE
    stiffness_1_s2: Triple | None = None
    damping_1_s: Triple | None = None

    @property
    def loop(self) -> PositionLoop | None:
        """The autopilot's own loop."""
        if self.stiffness_1_s2 is None or self.damping_1_s is None:
            return None
        return PositionLoop(np.array(self.stiffness_1_s2), np.array(self.damping_1_s))


class Control:
    """Makes one guarded setpoint after another for whatever tracker it was last told to follow.

    Args:
        settings: what it is told.
        tracker: to be followed first.
        recorder: is told of everything.
        announce: is told, in words, what of networks and online correction is flown, where that changes.

    Attributes:
        clips: how often the guard changed what.
        newest: the newest state, in the tracked frame; None until there is one.
        tracker: what is followed.
        error_m: the tracking error at the newest step (m); NaN before the first.
    """

    def __init__(
        self,
        settings: ControlSettings,
        tracker: Tracker,
        recorder: Recorder,
        announce: Callable[[str], None] = lambda text: None,
    ) -> None:
        self.clips: Counter[Clip] = Counter()
        self.newest: VehicleState | None = None
        self._settings = settings
        self._home = np.array(settings.home)
        self._heading = settings.yaw_mode.heading(settings.yaw, settings.period_s)
        self._recorder = recorder
        self._announce = announce
        self.tracker = tracker
        self.error_m = math.nan
        self._expectation = Expectation()
        self._frame = ContinuousFrame()
        self._before: Before | None = None

    @property
    def unpredicted_m(self) -> float:
        """How far the tracking error is from what the online model predicted of it (m); NaN without one."""
        return self._expectation.missed_m

    def begin(self, time_s: float, newest: VehicleState | None) -> None:
        """Begin at `time_s` (companion clock, s), the newest state being `newest`."""
        self.newest = newest
        self._recorder.control(time_s, self._settings.model_dump_json())
        self._recorder.follow(time_s, self.tracker)

    def follow(self, time_s: float, tracker: Tracker) -> None:
        """Follow another trajectory from the next step on."""
        self.tracker = tracker
        self._expectation.forget()
        self._recorder.follow(time_s, tracker)

    def observe(self, state: VehicleState) -> None:
        """Take in every state, as it arrives."""
        turn = 0.0 if self.newest is None else yaw_jump(self.newest, state)
        if turn:
            self._heading.shift(turn)
            self._recorder.event(state.received_s, f"the vehicle's estimated yaw jumped by {turn:.2f} rad")
        jump = self._frame.follow(state)
        self.newest = self._frame.tracked(state)
        if jump is not None:
            self.tracker.forget_motion()
            self._expectation.forget()
            jumped = np.round(jump, 2).tolist()
            self._recorder.event(state.received_s, f"the vehicle's estimate jumped by {jumped} m")
        self.tracker.observe(self.newest)

    def setpoint(self, now_s: float, state: VehicleState) -> tuple[Reference, float]:
        """What to send at `now_s`, the vehicle being in `state` then (of the tracked frame).

        Returns:
            The reference, in the vehicle's own frame, and the yaw (rad).

        Raises:
            TrackingError: the vehicle is too far from where it should be, or its estimate jumped too far.
        """
        step = self.tracker.step(state)
        self.error_m = tracking_error_m(state, step.desired)
        self._expectation.compare(state.time_s, step.desired.position - state.position)
        self._require_near()
        home = self._home - self._frame.offset_at(now_s)
        guarded = guard(
            *(step.u1, step.u2, step.plain),
            state=state,
            home=home,
            limits=self._settings.limits,
            vehicle_fence=self._settings.vehicle_fence,
            before=self._before,
        )
        self._before = Before(now_s, guarded.reference)
        expected = self.tracker.sent(guarded.reference, state)
        if expected is not None:
            self._expectation.expect(*expected)
        sent = self._frame.sent(guarded.reference, now_s)
        yaw = self._heading(step.desired.velocity)
        self._recorder.step(now_s, step, guarded, sent, yaw)
        for remark in step.remarks:
            self._recorder.event(now_s, remark, "learning")
            self._announce(remark)
        self._count(now_s, guarded)
        return sent, yaw

    def _require_near(self) -> None:
        limit_m = self._settings.limits.tracking_error_m
        if self.error_m > limit_m:
            raise TrackingError(
                f"the vehicle is {self.error_m:.1f} m from where it should be (limit {limit_m:g} m): "
                "check the trajectory, the wind and the model"
            )
        jumped_m = float(np.linalg.norm(self._frame.offset))
        if jumped_m > limit_m:
            raise TrackingError(
                f"the vehicle's estimate jumped by {jumped_m:.1f} m (limit {limit_m:g} m): "
                "check its estimator"
            )

    def _count(self, now_s: float, guarded: Guarded) -> None:
        for clip in guarded.clips:
            if not self.clips[clip]:
                self._recorder.event(now_s, f"guard: {clip}", "guard")
            self.clips[clip] += 1
