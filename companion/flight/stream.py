"""The stream of setpoints: one loop that steps, guards and sends, and stops sending when it stops working.

Nothing else sends setpoints, and nothing repeats an old one: when this loop dies or stalls, the stream ends,
and the autopilot's own failsafe takes over. It does not begin again by itself, for PX4 would go back to
OFFBOARD at the first setpoint, whoever has the vehicle by then.
"""

from companion import clock
from companion.autopilot.interface import Autopilot
from companion.errors import GapError
from companion.flight.control import Control
from companion.flight.foreign_setpoints import ForeignSetpoints
from companion.flight.tracker import Tracker
from companion.flight.watchdogs import Watchdog, WatchdogError
from companion.link.telemetry import Telemetry
from companion.state import VehicleState

_STALL_S = 0.1
"""A loop that wakes later than this was held up, and telemetry waits unread."""
_COMPUTING_OVER_S = 0.5


class SetpointStream:
    """Sends one setpoint each period.

    Args:
        autopilot: what flies the vehicle.
        telemetry: of the same vehicle.
        control: makes the setpoints.
        period_s: between two of them (s).
        state_age: from older telemetry none is made.
        timeout_s: how long the vehicle waits for setpoints before its failsafe acts (s).

    Attributes:
        control: makes the setpoints.
        computing: time that a step takes, as a share of the period; the mean of the last half second.
    """

    def __init__(
        self,
        autopilot: Autopilot,
        telemetry: Telemetry,
        control: Control,
        *,
        period_s: float,
        state_age: Watchdog,
        timeout_s: float,
    ) -> None:
        self._autopilot = autopilot
        self._telemetry = telemetry
        self.control = control
        self.computing = 0.0
        self._foreign = ForeignSetpoints()
        self._lateness_s = 0.0
        self._state_age = state_age
        self._oldest_s = min(state_age.limit, timeout_s)
        self._timeout_s = timeout_s
        self._period_s = period_s
        self._sent_s = self._listening_since_s = clock.now()

    def follow(self, tracker: Tracker) -> None:
        """Follow another trajectory from the next step on."""
        self.control.follow(clock.now(), tracker)

    def fall_back(self) -> None:
        """Follow the same trajectory with the plain strategy."""
        self.follow(self.control.tracker.plain())

    @property
    def foreign(self) -> float:
        """Share of the setpoints that the vehicle follows that are not of this stream; NaN if not known."""
        return self._foreign.share(self._telemetry.status.setpoint)

    def take_lateness_s(self) -> float:
        """How late the loop was at most (s), since this was asked for last."""
        lateness_s, self._lateness_s = self._lateness_s, 0.0
        return lateness_s

    async def run(self) -> None:
        """Send until cancelled.

        Raises:
            WatchdogError: the telemetry is too old.
            TrackingError: the vehicle is too far from where it should be, or its
                estimate jumped too far.
            GapError: this loop was held up, or the vehicle silent, for longer than it waits for setpoints.
        """
        due_s = self._sent_s = self._listening_since_s = clock.now()
        self.control.begin(due_s, self._telemetry.state)
        unsubscribe = self._telemetry.subscribe(self.control.observe)
        try:
            while True:
                now_s = clock.now()
                self._lateness_s = max(self._lateness_s, now_s - due_s)
                if now_s > due_s + _STALL_S:
                    self._listening_since_s = now_s
                self._send(now_s)
                due_s = max(due_s + self._period_s, clock.now())
                await clock.sleep_until(due_s)
        finally:
            unsubscribe()

    def _send(self, now_s: float) -> None:
        state = self._present_state(now_s)
        if state is None:
            return
        sent, yaw = self.control.setpoint(now_s, state)
        share = (clock.now() - now_s) / self._period_s
        self.computing += min(self._period_s / _COMPUTING_OVER_S, 1.0) * (share - self.computing)
        self._autopilot.send_setpoint(sent.position, sent.velocity, sent.acceleration, yaw)
        self._foreign.sent(now_s, sent.position)
        self._sent_s = now_s

    def _present_state(self, now_s: float) -> VehicleState | None:
        """The newest state carried to `now_s`; None where telemetry that waits must be read first."""
        gap_s = now_s - self._sent_s
        if gap_s > self._timeout_s:
            raise GapError(
                f"no setpoint was sent for {gap_s:.1f} s, and the vehicle waits {self._timeout_s:g} s: "
                "it was left to its own failsafe"
            )
        newest = self.control.newest
        if newest is not None and newest.age_s(now_s) <= self._oldest_s:
            return newest.at(now_s)
        if newest is not None and now_s - self._listening_since_s <= self._oldest_s:
            return None
        silent = f"no new position for {self._oldest_s:g} s: check the link and the vehicle's estimator"
        # A vehicle that may not have heard us for so long either is past its failsafe.
        raise (
            GapError(silent)
            if self._oldest_s >= self._timeout_s
            else WatchdogError(silent, self._state_age.action)
        )
