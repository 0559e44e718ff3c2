"""The correction that leaves the least expected error, given how uncertain the model is.

The paper corrects by α e with α = 1/G (section IV-A), as if its error e and gain G were known. They are a
posterior's; the expected square of what is left, E (e − G u2)², is least at u2 = E eG / E G². Adaptive
control calls this the cautious controller (Åström & Wittenmark, Adaptive Control, 2nd edition, 1995,
chapter 7). Since u2 = 0 is among the choices, no more is expected than the network alone would leave.
"""

from dataclasses import dataclass
from typing import TypeVar

from companion.arrays import Vec3

Each = TypeVar("Each", float, Vec3)


def cautious_gain(gain: Each, variance: Each) -> Each:
    """α = G/(G² + var G), of one axis or each: 1/G where G is known, 0 where nothing is.

    Args:
        gain: G, by how much a unit of u2 is expected to reduce the error; not 0 where the variance is.
        variance: of G.
    """
    return gain / (gain**2 + variance)


@dataclass(frozen=True)
class ErrorBelief:
    """What is known of the error e − G u2 that a correction u2 leaves: e and G are jointly Gaussian.

    Attributes:
        error, gain: means of e, the error without correction, and of G, by how much a unit of u2 reduces it.
        error_variance, gain_variance, covariance: of e, of G, and of both.
    """

    error: float
    gain: float
    error_variance: float = 0.0
    gain_variance: float = 0.0
    covariance: float = 0.0

    @property
    def alpha(self) -> float:
        """The gain of the correction (`cautious_gain`)."""
        return cautious_gain(self.gain, self.gain_variance)

    @property
    def correction(self) -> float:
        """The u2 that leaves the least expected square."""
        return (self.error * self.gain + self.covariance) / (self.gain**2 + self.gain_variance)

    def expected_square(self, correction: float) -> float:
        """E (e − G u2)² of another u2."""
        mean = self.error - self.gain * correction
        spread = correction * (correction * self.gain_variance - 2.0 * self.covariance)
        return mean**2 + self.error_variance + spread
