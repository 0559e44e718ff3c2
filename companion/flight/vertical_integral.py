"""What is held against a load: the vertical tracking error, integrated.

What is corrected is what the model predicts of deviations, and a weight that has changed is none: the vehicle
would hang lower until the autopilot's own integrator carries it, which takes PX4 two to three seconds.
"""

_LEAK_1_S = 0.5
"""The autopilot's own integrator takes over meanwhile; two that never forget work against each other."""
_FARTHEST_M = 0.4
"""More than as much again is left of the correction's length for what comes fast."""
_LARGEST_ERROR_M = 0.12
"""A larger one shows a vehicle whose motors give no more: nothing is gained by asking them, and what had been
gathered would carry the vehicle past where it should be."""


class VerticalIntegral:
    """The leaky integral of the vertical error, as an offset of the reference.

    Attributes:
        offset_m: of the reference, down (m).
    """

    def __init__(self, rate_1_s: float) -> None:
        self.offset_m = 0.0
        self._rate_1_s = rate_1_s
        self._integral_m = 0.0

    def add(self, error_m: float, alpha: float, duration_s: float) -> float:
        """Take in an error for `duration_s` (s), and how far the reference is moved: α ∫ e, within bounds."""
        telling_m = error_m if abs(error_m) <= _LARGEST_ERROR_M else 0.0  # of NaN, too
        self._integral_m += duration_s * (self._rate_1_s * telling_m - _LEAK_1_S * self._integral_m)
        offset_m = alpha * self._integral_m
        self.offset_m = min(max(offset_m, -_FARTHEST_M), _FARTHEST_M)
        if offset_m != self.offset_m:
            self._integral_m = self.offset_m / alpha
        return self.offset_m
