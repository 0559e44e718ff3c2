"""When, on the companion's clock, was what the vehicle tells of? An estimate of the clocks' offset.

A round trip (TIMESYNC, https://mavlink.io/en/services/timesync.html) brackets the offset: the vehicle read
its clock somewhere between question and answer. The shortest round trips of the last seconds bracket it
best, whatever the link's latency; a fixed limit on round trips would reject all of a slow link. Without
round trips, the frame that was least late bounds the offset from one side.
"""

from collections import deque
from math import inf
from statistics import fmean

_WINDOW_S = 3.0
_SHORTEST_SHARE = 0.25
"""Of the round trips in the window: those that the estimate is made of."""
_FILTER_S = 0.5
_FASTEST_SLEW = 0.1
"""Largest change of the offset, in seconds per second; below 1, so that time never runs backwards."""
_ANOTHER_CLOCK_S = 0.5
"""An offset that is off by more than this does not drift: the vehicle's clock leapt, or stood still."""
REBOOT_S = 3.0
"""No link delays a frame for this long: vehicle time that falls back farther is that of a reboot."""


class ClockOffset:
    """The offset (companion clock minus vehicle clock, s): smooth for as long as the clocks run evenly."""

    def __init__(self) -> None:
        self._offset = -inf
        self._vehicle_s = -inf
        self._bracketed: float | None = None
        self._round_trips: deque[tuple[float, float, float]] = deque()
        self._least_late: deque[tuple[float, float]] = deque()

    def round_trip(self, asked_s: float, vehicle_s: float, answered_s: float) -> None:
        """Learn from a question at `asked_s` that was answered at `answered_s` (companion clock, s).

        `vehicle_s` is what the vehicle's clock read in between (s).
        """
        trips = self._round_trips
        trips.append((answered_s, answered_s - asked_s, 0.5 * (asked_s + answered_s) - vehicle_s))
        while trips[0][0] < answered_s - _WINDOW_S:
            trips.popleft()
        shortest = sorted(duration_s for _, duration_s, _ in trips)[int(_SHORTEST_SHARE * len(trips))]
        self._bracketed = fmean(offset for _, duration_s, offset in trips if duration_s <= shortest)

    def companion_time(self, vehicle_s: float, received_s: float) -> float:
        """When it was `vehicle_s` (vehicle clock, s), on the companion's clock (s); learns from the arrival.

        Args:
            vehicle_s: of a frame; rising from call to call, or fallen by more than `REBOOT_S`.
            received_s: when the frame arrived (companion clock, s).

        Returns:
            Rising times, none later than its frame's arrival.
        """
        lateness = received_s - vehicle_s
        elapsed_s = vehicle_s - self._vehicle_s
        if elapsed_s < -REBOOT_S or lateness < self._offset - _ANOTHER_CLOCK_S:
            self._forget()
            elapsed_s = 0.0
        target = self._target(lateness, received_s)
        error = target - self._offset
        if error > _ANOTHER_CLOCK_S:
            self._offset = target
        else:
            fastest = _FASTEST_SLEW * elapsed_s
            step = error * min(1.0, elapsed_s / _FILTER_S)
            self._offset += max(-fastest, min(fastest, step))
        self._vehicle_s = vehicle_s
        return min(vehicle_s + self._offset, received_s)

    def _target(self, lateness: float, received_s: float) -> float:
        """The best estimate at this instant: bracketed by round trips, or else the least lateness."""
        bounds = self._least_late
        while bounds and bounds[-1][1] >= lateness:
            bounds.pop()
        bounds.append((received_s, lateness))
        while bounds[0][0] < received_s - _WINDOW_S:
            bounds.popleft()
        bound = bounds[0][1]
        # Some vehicles answer TIMESYNC from another clock than the one that stamps their telemetry.
        if self._bracketed is not None and abs(self._bracketed - bound) < _ANOTHER_CLOCK_S:
            return self._bracketed
        return bound

    def _forget(self) -> None:
        self._offset = -inf
        self._bracketed = None
        self._round_trips.clear()
        self._least_late.clear()
