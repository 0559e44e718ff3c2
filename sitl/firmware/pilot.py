"""The pilot's sticks: whether anybody moves them, and the velocity that they ask for."""

import math
from dataclasses import dataclass

import numpy as np

from sitl.arrays import Vec3

_GONE_AFTER_S = 0.5
"""PX4's default of COM_RC_LOSS_T."""
_DEAD_ZONE = 0.1


@dataclass(frozen=True, slots=True)
class Sticks:
    """Deflections, -1 to 1: right, forward, up, clockwise."""

    roll: float = 0.0
    pitch: float = 0.0
    climb: float = 0.0
    yaw: float = 0.0

    @property
    def largest(self) -> float:
        """The largest deflection."""
        return max(abs(self.roll), abs(self.pitch), abs(self.climb), abs(self.yaw))

    def velocity(self, heading: float, speed: float, up: float, down: float) -> Vec3:
        """What they ask for, NED (m/s), at full deflection for these speeds (m/s); `heading` in rad."""
        sine, cosine = math.sin(heading), math.cos(heading)
        north = self.pitch * cosine - self.roll * sine
        east = self.pitch * sine + self.roll * cosine
        return np.array((speed * north, speed * east, -self.climb * (up if self.climb > 0.0 else down)))


class Pilot:
    """Whoever holds the sticks, if anybody does."""

    def __init__(self) -> None:
        self.sticks = Sticks()
        self._heard_s = -math.inf

    def move(self, sticks: Sticks, time_s: float) -> None:
        """The sticks are there now."""
        self.sticks = sticks
        self._heard_s = time_s

    def is_there(self, time_s: float) -> bool:
        """Whether sticks were heard of lately."""
        return time_s - self._heard_s <= _GONE_AFTER_S

    def is_lost(self, since_s: float, after_s: float, time_s: float) -> bool:
        """Whether sticks that were heard of at `since_s` or later have been silent for `after_s` (s)."""
        return since_s <= self._heard_s < time_s - after_s

    def flies(self, time_s: float) -> bool:
        """Whether a stick is out of its middle."""
        return self.is_there(time_s) and self.sticks.largest > _DEAD_ZONE
