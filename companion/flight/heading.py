"""Where the nose points while the vehicle tracks: held, or along the path."""

import math
from enum import StrEnum

from companion.arrays import Vec3
from companion.flight.continuous_frame import LONGEST_GAP_S
from companion.state import VehicleState

_FASTEST_RAD_S = math.radians(45.0)
"""PX4 turns by at most MPC_YAWRAUTO_MAX, 60°/s, and ArduPilot by ATC_SLEW_YAW, the same."""
_TURNS_PER_S = 2.0
"""Of what is left to turn, this much a second."""
_SLOWEST_M_S = 0.1
_FULL_M_S = 0.5
"""Below the first the direction of the path says nothing; from there it gains weight up to the second."""

_SMALLEST_JUMP = math.radians(5.0)
_SMALLEST_JUMP_RAD_S = math.radians(30.0)
"""Jump of the estimated heading that counts: the first, and the second for each second between two states."""


class YawMode(StrEnum):
    """By the names that the command takes."""

    HOLD = "hold"
    PATH = "path"

    def heading(self, yaw: float, period_s: float) -> "Heading":
        """The heading that begins at `yaw` (rad) and is asked every `period_s` (s)."""
        return AlongPath(yaw, period_s) if self is YawMode.PATH else Heading(yaw)


class Heading:
    """The yaw to send at each control step: as it was found."""

    def __init__(self, yaw: float) -> None:
        self._yaw = yaw

    def __call__(self, velocity: Vec3) -> float:
        """The next yaw (rad), the desired velocity being `velocity` (NED, m/s)."""
        return self._yaw

    def shift(self, angle: float) -> None:
        """The vehicle's estimate of its yaw jumped by `angle` (rad): the nose is to stay where it is."""
        self._yaw = math.remainder(self._yaw + angle, math.tau)


class AlongPath(Heading):
    """Turns towards the horizontal velocity, at a limited rate; at a standstill it stays."""

    def __init__(self, yaw: float, period_s: float) -> None:
        super().__init__(yaw)
        self._period_s = period_s

    def __call__(self, velocity: Vec3) -> float:
        """The next yaw (rad)."""
        self._yaw = turned(self._yaw, velocity, self._period_s)
        return self._yaw


def yaw_jump(before: VehicleState, after: VehicleState) -> float:
    """How far the estimated yaw moved (rad) beside its own rate, as a reset has it; 0 where it did not."""
    elapsed_s = after.time_s - before.time_s
    turned_by = 0.5 * elapsed_s * (_yaw_rate(before) + _yaw_rate(after))
    jump = math.remainder(float(after.attitude[2] - before.attitude[2]) - turned_by, math.tau)
    smallest = _SMALLEST_JUMP + _SMALLEST_JUMP_RAD_S * elapsed_s
    return jump if elapsed_s < LONGEST_GAP_S and abs(jump) > smallest else 0.0


def turned(yaw: float, velocity: Vec3, elapsed_s: float) -> float:
    """`yaw` (rad), turned for `elapsed_s` (s) towards the horizontal part of `velocity` (m/s); in ±π."""
    north, east, _ = velocity
    weight = min(1.0, max(0.0, (math.hypot(north, east) - _SLOWEST_M_S) / (_FULL_M_S - _SLOWEST_M_S)))
    left = math.remainder(math.atan2(east, north) - yaw, math.tau)
    rate = min(_FASTEST_RAD_S, max(-_FASTEST_RAD_S, _TURNS_PER_S * left))
    return math.remainder(yaw + weight * rate * elapsed_s, math.tau)


def _yaw_rate(state: VehicleState) -> float:
    """Rate of the yaw angle (rad/s), from the rates about the body's axes."""
    (roll, pitch, _), (_, about_y, about_z) = state.attitude, state.rates
    return float((about_y * math.sin(roll) + about_z * math.cos(roll)) / math.cos(pitch))
