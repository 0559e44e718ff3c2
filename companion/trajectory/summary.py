"""What a trajectory asks of place, time and vehicle, in a few numbers."""

from dataclasses import dataclass

import numpy as np

from companion.arrays import Vec3
from companion.trajectory.drawing import SPEED_M_S
from companion.trajectory.limits import Limits, Peaks, peaks_of, stretches
from companion.trajectory.smoothing import lengths
from companion.trajectory.trajectory import Trajectory

_BINDING = 0.001
"""A limit is reached where less than this share of time would have to change to reach it."""
_INSTANTS_PER_KNOT = 8


@dataclass(frozen=True, eq=False)
class Summary:
    """A trajectory in numbers.

    Attributes:
        name: of the trajectory.
        lowest, highest: the least and the largest north, east and down (m).
        length_m: length of the path.
        duration_s: from the first to the last instant.
        peaks: the most of speed, acceleration, jerk, climb and descent.
        bound_by: the limits that are reached, by their names in `Limits`.
    """

    name: str
    lowest: Vec3
    highest: Vec3
    length_m: float
    duration_s: float
    peaks: Peaks
    bound_by: tuple[str, ...]

    def lines(self) -> list[str]:
        """The summary for people, a line each."""
        box = (
            f"{axis} {low:.2f} to {high:.2f}"
            for axis, low, high in zip(("north", "east", "down"), self.lowest, self.highest, strict=True)
        )
        peaks = self.peaks
        return [
            f"{self.name}: {self.length_m:.2f} m in {self.duration_s:.2f} s",
            f"box: {', '.join(box)} m",
            f"peaks: speed {peaks.speed_m_s:.2f} m/s (up {peaks.up_m_s:.2f}, down {peaks.down_m_s:.2f}), "
            f"acceleration {peaks.acceleration_m_s2:.2f} m/s², jerk {peaks.jerk_m_s3:.1f} m/s³",
            f"limit reached: {', '.join(self.bound_by) or 'none'}",
        ]


def summarise(trajectory: Trajectory, limits: Limits) -> Summary:
    """The summary of `trajectory`, which was made within `limits`."""
    instants = len(trajectory.coefficients) * _INSTANTS_PER_KNOT + 1
    positions = trajectory.sample(np.linspace(0.0, trajectory.duration_s, instants)).position
    peaks = peaks_of(trajectory)
    reached = stretches(peaks, limits.peaks(usual_speed_m_s=SPEED_M_S))
    return Summary(
        name=trajectory.name,
        lowest=positions.min(axis=0),
        highest=positions.max(axis=0),
        length_m=float(lengths(positions)[-1]),
        duration_s=trajectory.duration_s,
        peaks=peaks,
        bound_by=tuple(name for name, stretch in reached.items() if abs(stretch - 1.0) < _BINDING),
    )
