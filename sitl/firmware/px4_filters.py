"""PX4's low-pass filters: of first order for accelerations and torques, of second order for the gyro."""

import math
from typing import NamedTuple

from sitl.compiled import compiled


@compiled
def blend(cutoff_hz: float, dt: float) -> float:
    """Share of a sample that a first-order low pass lets through at once; a cutoff of 0 is no filter."""
    if cutoff_hz <= 0.0:
        return 1.0
    return dt / (1.0 / (2.0 * math.pi * cutoff_hz) + dt)


class LowPass2(NamedTuple):
    """y₀ = b₀ x₀ + b₁ x₁ + b₂ x₂ − a₁ y₁ − a₂ y₂, the index counting samples back."""

    b0: float
    b1: float
    b2: float
    a1: float
    a2: float


def low_pass_2(cutoff_hz: float, dt: float) -> LowPass2:
    """A Butterworth low pass for samples every `dt` (s), by the bilinear transform.

    As PX4 has it, there is no filter at a cutoff of 0 or from half the sample rate on.
    """
    if not 0.0 < cutoff_hz < 0.5 / dt:
        return LowPass2(1.0, 0.0, 0.0, 0.0, 0.0)
    warped = math.tan(math.pi * cutoff_hz * dt)
    scale = 1.0 + math.sqrt(2.0) * warped + warped**2
    b = warped**2 / scale
    return LowPass2(
        b0=b,
        b1=2.0 * b,
        b2=b,
        a1=2.0 * (warped**2 - 1.0) / scale,
        a2=(1.0 - math.sqrt(2.0) * warped + warped**2) / scale,
    )
