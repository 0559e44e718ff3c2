"""How far a flight was from what it was to fly."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from companion.arrays import Times, Vec3, Vec3s


@dataclass(frozen=True, eq=False)
class TrackingAccuracy:
    """The error of one flight along its trajectory.

    Attributes:
        rms_m: root mean square of the distance to the desired position (m).
        rms_axes_m: the same for north, east, down apart (m); their squares add up to that of `rms_m`.
        max_m: the largest distance (m).
    """

    rms_m: float
    rms_axes_m: Vec3
    max_m: float


def tracking_accuracy(
    desired_position: Callable[[Times], Vec3s], time_s: Times, position: Vec3s, start_s: float, end_s: float
) -> TrackingAccuracy:
    """The error from the first to the last instant of a trajectory, at each state's own time.

    Args:
        desired_position: where the vehicle was to be at given times (NED, m).
        time_s: time of each state (s), on the clock of `desired_position`.
        position: position of each state (NED, m).
        start_s: first instant of the trajectory (s); states before it do not count.
        end_s: last instant of the trajectory (s); states after it do not count.

    Raises:
        ValueError: when no state lies between them.
    """
    along = (time_s >= start_s) & (time_s <= end_s)
    if not along.any():
        raise ValueError(f"no state between {start_s} s and {end_s} s")
    squares = (position[along] - desired_position(time_s[along])) ** 2
    mean_squares = squares.mean(axis=0)
    return TrackingAccuracy(
        rms_m=float(np.sqrt(mean_squares.sum())),
        rms_axes_m=np.sqrt(mean_squares),
        max_m=float(np.sqrt(squares.sum(axis=1).max())),
    )


class ErrorSum:
    """`tracking_accuracy`, state by state as they come: what a flight of any length can hold.

    Args:
        desired_position: where the vehicle was to be at an instant (NED, m).
        start_s, end_s: first and last instant that count (s).
    """

    def __init__(self, desired_position: Callable[[float], Vec3], start_s: float, end_s: float) -> None:
        self._desired_position = desired_position
        self._start_s, self._end_s = start_s, end_s
        self._count = 0
        self._squares: Vec3 = np.zeros(3)
        self._max_square = 0.0

    def add(self, time_s: float, position: Vec3) -> None:
        """Take in where the vehicle was at `time_s` (NED, m)."""
        if self._start_s <= time_s <= self._end_s:
            squares = (position - self._desired_position(time_s)) ** 2
            self._count += 1
            self._squares = self._squares + squares
            self._max_square = max(self._max_square, float(squares.sum()))

    @property
    def accuracy(self) -> TrackingAccuracy:
        """Of what came so far; ValueError when nothing did that counts."""
        if not self._count:
            raise ValueError(f"no state between {self._start_s} s and {self._end_s} s")
        mean_squares: Vec3 = self._squares / self._count
        return TrackingAccuracy(
            rms_m=float(np.sqrt(mean_squares.sum())),
            rms_axes_m=np.sqrt(mean_squares),
            max_m=float(np.sqrt(self._max_square)),
        )
