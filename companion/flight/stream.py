"""The stream of setpoints: one loop that steps, guards and sends, and stops sending when it stops working.

Nothing else sends setpoints, and nothing repeats an old one: when this loop dies or stalls, the stream ends,
and the autopilot's own failsafe takes over.
"""

from collections import Counter

from companion import clock
from companion.arrays import Vec3
from companion.autopilot.interface import Autopilot
from companion.errors import TrackingError
from companion.flight.guard import Clip, Guarded, GuardLimits, guard
from companion.flight.recorder import FlightRecorder
from companion.flight.tracker import ControlStep, Tracker, tracking_error_m
from companion.link.telemetry import Telemetry


class SetpointStream:
    """Sends one guarded reference each period for whatever tracker it was last told to follow.

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
        yaw: float,
        limits: GuardLimits,
        period_s: float,
    ) -> None:
        self.clips: Counter[Clip] = Counter()
        self._autopilot = autopilot
        self._telemetry = telemetry
        self._home = home
        self._yaw = yaw
        self._limits = limits
        self._recorder = recorder
        self._period_s = period_s
        self._tracker = tracker

    def follow(self, tracker: Tracker) -> None:
        """Follow another trajectory from the next step on."""
        self._tracker = tracker

    async def run(self) -> None:
        """Send until cancelled.

        Raises:
            TrackingError: the telemetry is too old, or the vehicle too far from where it should be.
        """
        unsubscribe = self._telemetry.subscribe(lambda state: self._tracker.observe(state))
        try:
            due_s = clock.now()
            while True:
                self._send(clock.now())
                due_s = max(due_s + self._period_s, clock.now())
                await clock.sleep_until(due_s)
        finally:
            unsubscribe()

    def _send(self, now_s: float) -> None:
        newest = self._telemetry.state
        if newest is None or newest.age_s(now_s) > self._limits.state_age_s:
            raise TrackingError(
                f"no telemetry for {self._limits.state_age_s:g} s: check the link and the vehicle's estimator"
            )
        state = newest.at(now_s)
        step = self._tracker.step(state)
        error_m = tracking_error_m(state, step.desired)
        if error_m > self._limits.tracking_error_m:
            raise TrackingError(
                f"the vehicle is {error_m:.1f} m from where it should be (limit "
                f"{self._limits.tracking_error_m:g} m): check the trajectory, the wind and the model"
            )
        guarded = guard(step.u1, step.u2, step.plain, state=state, home=self._home, limits=self._limits)
        reference = guarded.reference
        self._autopilot.send_setpoint(
            reference.position, reference.velocity, reference.acceleration, self._yaw
        )
        self._tracker.sent(reference, state)
        self._note(now_s, step, guarded)

    def _note(self, now_s: float, step: ControlStep, guarded: Guarded) -> None:
        self._recorder.step(now_s, step, guarded, self._yaw)
        for clip in guarded.clips:
            if not self.clips[clip]:
                self._recorder.event(now_s, f"guard: {clip}")
            self.clips[clip] += 1
