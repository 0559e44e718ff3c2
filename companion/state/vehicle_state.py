"""One estimate of the vehicle's motion, and the time at which it held."""

from dataclasses import dataclass

import numpy as np

from companion.arrays import Vec3


@dataclass(frozen=True, slots=True, eq=False)
class VehicleState:
    """What the autopilot estimated, and when.

    Attributes:
        time_s: companion clock at which the estimate held (s).
        received_s: companion clock at which its last message arrived (s).
        position: NED of the vehicle's local origin (m).
        velocity: NED (m/s).
        attitude: roll, pitch, yaw (rad).
        rates: body rates p, q, r (rad/s).
    """

    time_s: float
    received_s: float
    position: Vec3
    velocity: Vec3
    attitude: Vec3
    rates: Vec3

    def age_s(self, now_s: float) -> float:
        """How old the estimate is at `now_s` of the companion clock (s)."""
        return now_s - self.time_s

    def is_finite(self) -> bool:
        """Whether every number in it is finite."""
        return all(
            bool(np.isfinite(part).all())
            for part in (self.position, self.velocity, self.attitude, self.rates)
        )
