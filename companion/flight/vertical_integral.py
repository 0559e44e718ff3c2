"""What is held against a load: the vertical tracking error, integrated.

What is corrected is what the model predicts of deviations, and a weight that has changed is none: the vehicle
would hang lower until the autopilot's own integrator carries it, which takes PX4 two to three seconds.
"""

import math

_LEAK_1_S = 0.5
"""The autopilot's own integrator takes over meanwhile; two that never forget work against each other."""
_LARGEST_ERROR_M = 0.12
"""A larger one is not counted: it comes of motors that give no more, or is being caught up with, and what had
been gathered would carry the vehicle past where it should be."""


class VerticalIntegral:
    """The leaky integral of the vertical error, as an offset of the reference.

    Args:
        rate_1_s: how fast an error is integrated (1/s).
        farthest_m: the offset is at most so large (m).

    Attributes:
        offset_m: of the reference, down (m).
    """

    def __init__(self, rate_1_s: float, farthest_m: float) -> None:
        self.offset_m = 0.0
        self._rate_1_s = rate_1_s
        self._farthest_m = farthest_m
        self._integral_m = 0.0

    def add(self, error_m: float, alpha: float, duration_s: float) -> float:
        """Take in an error, desired less flown, down (m), for `duration_s` (s).

        Returns:
            The new offset, α (of the down axis, without unit) times the integral (m).
        """
        counted_m = error_m if abs(error_m) <= _LARGEST_ERROR_M else 0.0  # of NaN, too
        self._integral_m += duration_s * (self._rate_1_s * counted_m - _LEAK_1_S * self._integral_m)
        if abs(alpha * self._integral_m) > self._farthest_m:
            self._integral_m = math.copysign(self._farthest_m / alpha, self._integral_m)
        self.offset_m = alpha * self._integral_m
        return self.offset_m
