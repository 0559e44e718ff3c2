"""What an estimated velocity is wrong by: how fast the estimated position moves beside it."""

import math

import numpy as np

from companion.arrays import Vec3
from companion.state import VehicleState

_RATE_1_S = 1.5
"""Of the low pass. A velocity is wrong for seconds; the noise of a position, differentiated, is faster."""
LONGEST_GAP_S = 0.2
"""Between two states further apart than this, the motion in between is not known."""


class SlowDrift:
    """The drift d p̂/dt − v̂, low-passed twice, from state to state.

    Attributes:
        velocity: the newest drift, NED (m/s).
    """

    def __init__(self) -> None:
        self.forget()

    def forget(self) -> None:
        """Begin anew, as after a jump of the estimate."""
        self.velocity: Vec3 = np.zeros(3)
        self._once: Vec3 = np.zeros(3)
        self._newest: VehicleState | None = None

    def observe(self, state: VehicleState) -> None:
        """Take in the newest state; times rise."""
        before, self._newest = self._newest, state
        if before is None or not 0.0 < state.time_s - before.time_s <= LONGEST_GAP_S:
            return
        elapsed_s = state.time_s - before.time_s
        drift = (state.position - before.position) / elapsed_s - 0.5 * (state.velocity + before.velocity)
        fresh = 1.0 - math.exp(-_RATE_1_S * elapsed_s)
        self._once = self._once + fresh * (drift - self._once)
        self.velocity = self.velocity + fresh * (self._once - self.velocity)
