"""Where the nose points while the vehicle tracks: held, or along the path."""

import math
from collections.abc import Callable
from enum import StrEnum
from typing import TypeAlias

from companion.arrays import Vec3

Heading: TypeAlias = Callable[[Vec3], float]
"""The yaw to send (rad) at a control step, from the desired velocity (NED, m/s)."""

_FASTEST_RAD_S = math.radians(45.0)
"""PX4 turns by at most MPC_YAWRAUTO_MAX, 60°/s, and ArduPilot by ATC_SLEW_YAW, the same."""
_TURNS_PER_S = 2.0
"""Of what is left to turn, this much a second."""
_SLOWEST_M_S = 0.1
_FULL_M_S = 0.5
"""Below the first the direction of the path says nothing; from there it gains weight up to the second."""


class YawMode(StrEnum):
    """By the names that the command takes."""

    HOLD = "hold"
    PATH = "path"

    def heading(self, yaw: float, period_s: float) -> Heading:
        """The heading that begins at `yaw` (rad) and is asked every `period_s` (s)."""
        return AlongPath(yaw, period_s) if self is YawMode.PATH else lambda velocity: yaw


class AlongPath:
    """Turns towards the horizontal velocity, at a limited rate; at a standstill it stays."""

    def __init__(self, yaw: float, period_s: float) -> None:
        self._yaw = yaw
        self._period_s = period_s

    def __call__(self, velocity: Vec3) -> float:
        """The next yaw (rad)."""
        self._yaw = turned(self._yaw, velocity, self._period_s)
        return self._yaw


def turned(yaw: float, velocity: Vec3, elapsed_s: float) -> float:
    """`yaw` (rad), turned for `elapsed_s` (s) towards the horizontal part of `velocity` (m/s); in ±π."""
    north, east, _ = velocity
    weight = min(1.0, max(0.0, (math.hypot(north, east) - _SLOWEST_M_S) / (_FULL_M_S - _SLOWEST_M_S)))
    left = math.remainder(math.atan2(east, north) - yaw, math.tau)
    rate = min(_FASTEST_RAD_S, max(-_FASTEST_RAD_S, _TURNS_PER_S * left))
    return math.remainder(yaw + weight * rate * elapsed_s, math.tau)
