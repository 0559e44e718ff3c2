"""One estimate of the vehicle's motion, and the time at which it held."""

from dataclasses import dataclass, replace

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

    def at(self, time_s: float) -> "VehicleState":
        """The state carried to `time_s` (companion clock, s) at constant velocity and constant body rates.

        Meant for the tens of milliseconds by which telemetry is late.
        """
        ahead_s = time_s - self.time_s
        if ahead_s == 0.0:
            return self
        return replace(
            self,
            time_s=time_s,
            position=self.position + ahead_s * self.velocity,
            attitude=self.attitude + ahead_s * self.rates,
        )

    def is_finite(self) -> bool:
        """Whether every number in it is finite."""
        return all(
            bool(np.isfinite(part).all())
            for part in (self.position, self.velocity, self.attitude, self.rates)
        )
