"""How PX4 leaves and finds the ground: takeoff phases with a thrust ramp, and the land detector."""

import math
from enum import IntEnum

from sitl.firmware.px4_parameters import Px4Parameters
from sitl.vehicle import GRAVITY_M_S2

_LANDED_AFTER_S = 1.0
_LOW_THRUST_SHARE = 0.3
_STANDSTILL_M_S = 0.5
_CLIMBING_M_S = 0.3
_TILT_LIMIT_RAD_S = 0.2
"""How fast the limit of the tilt widens after a takeoff."""


class TakeoffPhase(IntEnum):
    """Phases between disarmed and flying, in their order."""

    DISARMED = 0
    SPOOLUP = 1
    READY = 2
    RAMPUP = 3
    FLIGHT = 4


class Takeoff:
    """Takeoff phases (PX4's `Takeoff`): spool up, wait for a wish to fly, ramp up the climb rate.

    Attributes:
        phase: the present one.
        max_tilt: rad.
    """

    def __init__(self, parameters: Px4Parameters) -> None:
        self.phase = TakeoffPhase.DISARMED
        self.use(parameters)
        self.max_tilt = self._max_tilt_landed
        self._elapsed_s = 0.0

    def use(self, parameters: Px4Parameters) -> None:
        """Go by these from now on."""
        self._max_tilt_landed = math.radians(parameters.MPC_TILTMAX_LND)
        self._max_tilt_flying = math.radians(parameters.MPC_TILTMAX_AIR)
        self._spoolup_s = parameters.COM_SPOOLUP_TIME
        self._ramp_s = max(parameters.MPC_TKO_RAMP_T, 1e-3)
        self._no_thrust_speed = -GRAVITY_M_S2 / parameters.MPC_Z_VEL_P_ACC

    def update(self, *, armed: bool, landed: bool, wanted: bool, dt: float) -> None:
        """Move on by `dt` (s); `wanted`: the present mode asks to leave the ground."""
        before = self.phase
        self._elapsed_s += dt
        if not armed:
            self.phase = TakeoffPhase.DISARMED
        elif self.phase is TakeoffPhase.DISARMED:
            self.phase = TakeoffPhase.SPOOLUP
        elif self.phase is TakeoffPhase.SPOOLUP and self._elapsed_s >= self._spoolup_s:
            self.phase = TakeoffPhase.READY
        elif self.phase is TakeoffPhase.READY and wanted:
            self.phase = TakeoffPhase.RAMPUP
        elif self.phase is TakeoffPhase.RAMPUP and self._elapsed_s >= self._ramp_s:
            self.phase = TakeoffPhase.FLIGHT
        elif self.phase is TakeoffPhase.FLIGHT and landed:
            self.phase = TakeoffPhase.READY
        if self.phase is not before:
            self._elapsed_s = 0.0
        flying = self.phase is TakeoffPhase.FLIGHT
        change = (self._max_tilt_flying if flying else self._max_tilt_landed) - self.max_tilt
        self.max_tilt += min(max(change, -_TILT_LIMIT_RAD_S * dt), _TILT_LIMIT_RAD_S * dt)

    def skip(self) -> None:
        """Be flying already."""
        self.phase = TakeoffPhase.FLIGHT
        self.max_tilt = self._max_tilt_flying

    def climb_limit(self, max_up: float) -> float:
        """Upper limit of the climb rate (m/s): from the one that gives no thrust to `max_up`."""
        if self.phase is TakeoffPhase.FLIGHT:
            return max_up
        progress = self._elapsed_s / self._ramp_s if self.phase is TakeoffPhase.RAMPUP else 0.0
        return self._no_thrust_speed + progress * (max_up - self._no_thrust_speed)


class LandDetector:
    """Landed: little thrust and no motion for a second; in the air: climbing, or through with taking off."""

    def __init__(self, parameters: Px4Parameters) -> None:
        self.landed = True
        self._still_s = 0.0
        self.use(parameters)

    def use(self, parameters: Px4Parameters) -> None:
        """Go by these from now on."""
        self._low_thrust = _LOW_THRUST_SHARE * parameters.MPC_THR_HOVER

    def update(
        self, *, phase: TakeoffPhase, speed: float, climb_rate: float, thrust: float, dt: float
    ) -> None:
        """Move on by `dt` (s); `speed` and `climb_rate` estimated (m/s), `thrust` commanded (0 to 1)."""
        if self.landed:
            climbing = phase is TakeoffPhase.RAMPUP and climb_rate > _CLIMBING_M_S
            self.landed = not (climbing or phase is TakeoffPhase.FLIGHT)
            self._still_s = 0.0
            return
        still = thrust < self._low_thrust and speed < _STANDSTILL_M_S
        self._still_s = self._still_s + dt if still else 0.0
        self.landed = phase is TakeoffPhase.DISARMED or self._still_s >= _LANDED_AFTER_S
