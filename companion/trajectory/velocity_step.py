"""A change of velocity in the least time that its limits on acceleration and jerk allow, smooth to the jerk.

The acceleration rises along half a cosine, stays, and falls along half a cosine: a Tukey window. While it
lasts, the velocity is a mean of those before and after, so that it is within every limit that both are in.
"""

import math
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from companion.arrays import Array

SHORTEST_RAMP_S = 0.2
"""Least time for the acceleration to rise: what is shorter is lost between the knots of a trajectory."""
_VARIANCE = 0.25 - 2.0 / math.pi**2
"""Of half a wave of a cosine, one unit long."""


@dataclass(frozen=True, slots=True)
class VelocityStep:
    """How long a change of velocity takes.

    Attributes:
        ramp_s: for which the acceleration rises, and again for which it falls.
        spread_s: from the middle of one ramp to the middle of the other.
    """

    ramp_s: float
    spread_s: float

    @property
    def duration_s(self) -> float:
        """How long it takes (s)."""
        return self.ramp_s + self.spread_s

    @property
    def cut_s(self) -> float:
        """How near the path passes the corner that an instant step in the middle would have made.

        In metres for each m/s of change: half the mean distance in time of the change from its middle.
        """
        return 0.125 * self.spread_s + 0.5 * _VARIANCE * self.ramp_s**2 / self.spread_s


def velocity_step(change_m_s: float, acceleration_m_s2: float, jerk_m_s3: float) -> VelocityStep:
    """The shortest change by `change_m_s` (m/s) within the limits on acceleration and jerk.

    Over ramps of length r the jerk is π/2 of the mean: j = π a / (2 r).
    """
    for_jerk = math.sqrt(0.5 * math.pi * change_m_s / jerk_m_s3)
    for_both = 0.5 * math.pi * acceleration_m_s2 / jerk_m_s3
    ramp_s = max(SHORTEST_RAMP_S, min(for_jerk, for_both))
    return VelocityStep(ramp_s, max(ramp_s, change_m_s / acceleration_m_s2))


def progress(
    elapsed_s: Float[Array, " n"], ramp_s: Float[Array, " n"], spread_s: Float[Array, " n"]
) -> tuple[Float[Array, " n"], Float[Array, " n"], Float[Array, " n"]]:
    """How far steps have come `elapsed_s` after they began, each its own: from rest to one m/s.

    Returns:
        Metres, m/s and m/s².
    """
    rises = _rise(elapsed_s, ramp_s), _rise(elapsed_s - spread_s, ramp_s)
    distance, speed, acceleration = (
        (first - second) / spread_s for first, second in zip(*rises, strict=True)
    )
    return distance, speed, acceleration


def _rise(
    elapsed_s: Float[Array, " n"], ramp_s: Float[Array, " n"]
) -> tuple[Float[Array, " n"], Float[Array, " n"], Float[Array, " n"]]:
    """An acceleration that rises to one and stays: its double integral, its integral, and itself."""
    rising = np.clip(elapsed_s, 0.0, ramp_s)
    risen = np.maximum(elapsed_s - ramp_s, 0.0)
    per_s = np.pi / ramp_s
    level = 0.5 * (1.0 - np.cos(per_s * rising))
    speed = 0.5 * (rising - np.sin(per_s * rising) / per_s)
    distance = 0.25 * rising**2 - level / per_s**2
    return distance + speed * risen + 0.5 * risen**2, speed + risen, level
