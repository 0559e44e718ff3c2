"""From the clock of the machine that recorded to the vehicle's clock, through the telemetry.

Each frame of telemetry carries the vehicle's time and arrives a little later, more or less late. Of a few
frames in a row the least late one tells the clocks' offset best; between two such frames time runs evenly.
A straight line through a whole flight would not do: a simulator that shares its machine runs slower than the
wall's clock, and now and then stands still for a tenth of a second.
"""

from dataclasses import dataclass

import numpy as np

from companion.arrays import Times
from companion.recording.series import Indices

FRAMES = 20
"""Of so many frames in a row the least late is believed: 0.1 s of a fast telemetry, seconds of a slow one."""


@dataclass(frozen=True, eq=False)
class ClockMap:
    """Instants on both clocks that belong together, rising on each (s)."""

    received_s: Times
    vehicle_s: Times

    def __call__(self, time_s: Times) -> Times:
        """The vehicle's time (s) at `time_s` on the recording machine's clock (s); never falls as that rises.

        Linear between the known instants; beyond them, both clocks run alike.
        """
        known = np.clip(time_s, self.received_s[0], self.received_s[-1])
        return np.interp(known, self.received_s, self.vehicle_s) + (time_s - known)


def fit_clock(received_s: Times, vehicle_s: Times) -> ClockMap:
    """The map that the frames of one flight give, from at least one frame.

    Args:
        received_s: when each frame arrived (s, the recording machine's clock), in any order.
        vehicle_s: the vehicle's time in it (s).
    """
    order = np.argsort(received_s, kind="stable")
    received_s, vehicle_s = received_s[order], vehicle_s[order]
    late_s = received_s - vehicle_s
    least_late = np.array(
        [start + np.argmin(late_s[start : start + FRAMES]) for start in range(0, len(late_s), FRAMES)]
    )
    received_s, vehicle_s = received_s[least_late], vehicle_s[least_late]
    known = rising(vehicle_s)
    return ClockMap(received_s[known], vehicle_s[known])


def rising(time_s: Times) -> Indices:
    """Indices of those times that are later than all before them."""
    latest_s = np.maximum.accumulate(time_s)
    return np.flatnonzero(np.diff(latest_s, prepend=-np.inf) > 0.0)
