"""The stream of setpoints: one loop that steps, guards and sends, and stops sending when it stops working.

Nothing else sends setpoints, and nothing repeats an old one: when this loop dies or stalls, the stream ends,
and the autopilot's own failsafe takes over. It does not begin again by itself, for PX4 would go back to
OFFBOARD at the first setpoint, whoever has the vehicle by then.
"""

from collections import Counter
from dataclasses import replace

import numpy as np

from companion import clock
from companion.arrays import Vec3
from companion.autopilot.interface import Autopilot
from companion.errors import GapError, TrackingError
from companion.flight.continuous_frame import ContinuousFrame
from companion.flight.guard import Clip, Guarded, GuardLimits, guard
from companion.flight.heading import Heading, yaw_jump
from companion.flight.recorder import FlightRecorder
from companion.flight.tracker import ControlStep, Tracker, tracking_error_m
from companion.link.telemetry import Telemetry
from companion.state import VehicleState

_STALL_S = 0.1
"""A loop that wakes later than this was held up, and telemetry waits unread."""


class SetpointStream:
    """Sends one guarded reference each period for whatever tracker it was last told to follow.

    Args:
        autopilot: what flies the vehicle.
        telemetry: of the same vehicle.
        recorder: is told of each step.
        tracker: to be followed first.
        home: the takeoff point, NED (m).
        heading: where the nose points.
        limits: of the guard.
        period_s: between two setpoints (s).
        timeout_s: how long the vehicle waits for setpoints before its failsafe acts (s).

    Attributes:
        clips: how often the guard changed what.
    """

    def __init__(
        self,
        autopilot: Autopilot,
        telemetry: Telemetry,
        recorder: FlightRecorder,
        tracker: Tracker,
        *,
        home: Vec3,
        heading: Heading,
        limits: GuardLimits,
        period_s: float,
        timeout_s: float,
    ) -> None:
        self.clips: Counter[Clip] = Counter()
        self._autopilot = autopilot
        self._telemetry = telemetry
        self._home = home
        self._heading = heading
        self._limits = limits
        self._oldest_s = min(limits.state_age_s, timeout_s)
        self._timeout_s = timeout_s
        self._recorder = recorder
        self._period_s = period_s
        self._tracker = tracker
        self._frame = ContinuousFrame()
        self._newest = telemetry.state
        self._sent_s = self._listening_since_s = clock.now()

    def follow(self, tracker: Tracker) -> None:
        """Follow another trajectory from the next step on."""
        self._tracker = tracker

    async def run(self) -> None:
        """Send until cancelled.

        Raises:
            TrackingError: the telemetry is too old, the vehicle too far from where it should be, or its
                estimate jumped too far.
            GapError: this loop was held up, or the vehicle silent, for longer than it waits for setpoints.
        """
        unsubscribe = self._telemetry.subscribe(self._observe)
        try:
            due_s = self._sent_s = self._listening_since_s = clock.now()
            while True:
                now_s = clock.now()
                if now_s > due_s + _STALL_S:
                    self._listening_since_s = now_s
                self._send(now_s)
                due_s = max(due_s + self._period_s, clock.now())
                await clock.sleep_until(due_s)
        finally:
            unsubscribe()

    def _observe(self, state: VehicleState) -> None:
        turn = 0.0 if self._newest is None else yaw_jump(self._newest, state)
        if turn:
            self._heading.shift(turn)
            self._recorder.event(clock.now(), f"the vehicle's estimated yaw jumped by {turn:.2f} rad")
        jump = self._frame.follow(state)
        self._newest = self._frame.tracked(state)
        if jump is not None:
            self._tracker.forget_motion()
            self._recorder.event(
                clock.now(), f"the vehicle's estimate jumped by {np.round(jump, 2).tolist()} m"
            )
        self._tracker.observe(self._newest)

    def _send(self, now_s: float) -> None:
        state = self._present_state(now_s)
        if state is None:
            return
        step = self._tracker.step(state)
        self._require_near(state, step)
        offset = self._frame.offset_at(now_s)
        guarded = guard(
            step.u1, step.u2, step.plain, state=state, home=self._home - offset, limits=self._limits
        )
        self._tracker.sent(guarded.reference, state)
        sent = self._frame.sent(guarded.reference, now_s)
        yaw = self._heading(step.desired.velocity)
        self._autopilot.send_setpoint(sent.position, sent.velocity, sent.acceleration, yaw)
        self._sent_s = now_s
        self._note(now_s, step, replace(guarded, reference=sent), yaw)

    def _present_state(self, now_s: float) -> VehicleState | None:
        """The newest state carried to `now_s`; None where telemetry that waits must be read first."""
        gap_s = now_s - self._sent_s
        if gap_s > self._timeout_s:
            raise GapError(
                f"no setpoint was sent for {gap_s:.1f} s, and the vehicle waits {self._timeout_s:g} s: "
                "it was left to its own failsafe"
            )
        newest = self._newest
        if newest is not None and newest.age_s(now_s) <= self._oldest_s:
            return newest.at(now_s)
        if newest is not None and now_s - self._listening_since_s <= self._oldest_s:
            return None
        silent = f"no telemetry for {self._oldest_s:g} s: check the link and the vehicle's estimator"
        # A vehicle that may not have heard us for so long either is past its failsafe.
        raise GapError(silent) if self._oldest_s >= self._timeout_s else TrackingError(silent)

    def _require_near(self, state: VehicleState, step: ControlStep) -> None:
        error_m = tracking_error_m(state, step.desired)
        if error_m > self._limits.tracking_error_m:
            raise TrackingError(
                f"the vehicle is {error_m:.1f} m from where it should be (limit "
                f"{self._limits.tracking_error_m:g} m): check the trajectory, the wind and the model"
            )
        jumped_m = float(np.linalg.norm(self._frame.offset))
        if jumped_m > self._limits.tracking_error_m:
            raise TrackingError(
                f"the vehicle's estimate jumped by {jumped_m:.1f} m (limit "
                f"{self._limits.tracking_error_m:g} m): check its estimator"
            )

    def _note(self, now_s: float, step: ControlStep, guarded: Guarded, yaw: float) -> None:
        self._recorder.step(now_s, step, guarded, yaw)
        for clip in guarded.clips:
            if not self.clips[clip]:
                self._recorder.event(now_s, f"guard: {clip}")
            self.clips[clip] += 1
