"""A frame in which the vehicle's estimate does not jump.

An estimator that resets moves its position at once, while the vehicle stays where it is. Sent on unchanged,
the next setpoint would be a step as long as the jump. So tracking happens in a frame that jumps with the
estimate and is eased back afterwards: the setpoint moves with the jump, and returns to the trajectory slowly.
"""

import math
from dataclasses import replace

import numpy as np

from companion.arrays import Vec3
from companion.flight.reference import Reference
from companion.state import VehicleState

_SMALLEST_JUMP_M = 0.2
_SMALLEST_JUMP_M_S = 0.5
"""Jump that counts: the first, and the second for each second between two states. What an estimate moves
beside its own velocity without a reset is up to 0.06 m in 20 ms in recordings of PX4's simulator."""
LONGEST_GAP_S = 1.0
"""Between two states; across longer gaps the vehicle may have flown and turned anywhere."""
_EASE_1_S = 0.25
"""How fast the frame returns (1/s): after a jump of 3 m at 0.28 m/s and 0.19 m/s² at most."""


class ContinuousFrame:
    """Where the tracked frame lies in the vehicle's own; the same until the estimate first jumps.

    Attributes:
        offset: of the tracked frame's origin at the newest state, NED of the vehicle's frame (m).
    """

    def __init__(self) -> None:
        self.offset: Vec3 = np.zeros(3)
        self._rate: Vec3 = np.zeros(3)
        self._last: VehicleState | None = None

    def follow(self, state: VehicleState) -> Vec3 | None:
        """Take in each state of the vehicle, in order; how far its estimate jumped with it (m), if it did."""
        last, self._last = self._last, state
        if last is None:
            return None
        elapsed_s = state.time_s - last.time_s
        self.offset, self._rate = _eased(self.offset, self._rate, elapsed_s)
        flown = 0.5 * elapsed_s * (last.velocity + state.velocity)
        jump: Vec3 = state.position - last.position - flown
        smallest_m = _SMALLEST_JUMP_M + _SMALLEST_JUMP_M_S * elapsed_s
        jumped = elapsed_s < LONGEST_GAP_S and math.hypot(*jump) > smallest_m
        if jumped:
            self.offset = self.offset + jump
        return jump if jumped else None

    def tracked(self, state: VehicleState) -> VehicleState:
        """A state of the vehicle's frame, in the tracked one; `state` is the newest that was followed."""
        return replace(state, position=state.position - self.offset, velocity=state.velocity - self._rate)

    def offset_at(self, time_s: float) -> Vec3:
        """`offset`, carried on to `time_s` (companion clock, s)."""
        elapsed_s = 0.0 if self._last is None else time_s - self._last.time_s
        return self.offset + elapsed_s * self._rate

    def sent(self, reference: Reference, time_s: float) -> Reference:
        """A reference of the tracked frame at `time_s`, in the vehicle's."""
        return Reference(
            reference.position + self.offset_at(time_s),
            reference.velocity + self._rate,
            reference.acceleration,
        )


def _eased(offset: Vec3, rate: Vec3, elapsed_s: float) -> tuple[Vec3, Vec3]:
    """Offset (m) and its rate (m/s) after `elapsed_s` of a critically damped return to none."""
    keep = math.exp(-_EASE_1_S * elapsed_s)
    pull = rate + _EASE_1_S * offset
    return keep * (offset + elapsed_s * pull), keep * (rate - _EASE_1_S * elapsed_s * pull)
