"""How PX4 leaves and finds the ground: takeoff phases with a thrust ramp, land detector, disarming."""

import math
from enum import IntEnum

from sitl.arrays import Vec3
from sitl.firmware.px4_parameters import Px4Parameters
from sitl.vehicle import GRAVITY_M_S2

_LANDED_AFTER_S = 1.0
_LOW_THRUST_SHARE = 0.3
_STANDSTILL_M_S = 0.5
_CREEPING_M_S = 1.5
"""LNDMC_XY_VEL_MAX: an estimate may move sideways on the ground."""
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

    def update(self, phase: TakeoffPhase, velocity: Vec3, thrust: float, dt: float) -> None:
        """Move on by `dt` (s); `velocity` estimated, NED (m/s), `thrust` commanded (0 to 1)."""
        north, east, down = velocity
        if self.landed:
            climbing = phase is TakeoffPhase.RAMPUP and -down > _CLIMBING_M_S
            self.landed = not (climbing or phase is TakeoffPhase.FLIGHT)
            self._still_s = 0.0
            return
        moves = abs(down) >= _STANDSTILL_M_S or math.hypot(north, east) >= _CREEPING_M_S
        still = thrust < self._low_thrust and not moves
        self._still_s = self._still_s + dt if still else 0.0
        self.landed = phase is TakeoffPhase.DISARMED or self._still_s >= _LANDED_AFTER_S


class AutoDisarm:
    """Disarms who stays on the ground: COM_DISARM_LAND after a flight, COM_DISARM_PRFLT before one.

    Attributes:
        has_flown: whether the vehicle was in the air since it was armed.
    """

    def __init__(self) -> None:
        self.has_flown = False
        self._since_s = 0.0

    def begin(self, time_s: float) -> None:
        """Armed now (s)."""
        self.has_flown = False
        self._since_s = time_s

    def wait(self, time_s: float) -> None:
        """Count from now (s)."""
        self._since_s = time_s

    def is_due(self, parameters: Px4Parameters, time_s: float, *, amid_mission: bool) -> bool:
        """Whether it is time (s); not after a landing in a mission that goes on."""
        p = parameters
        limit_s = p.COM_DISARM_LAND if self.has_flown else p.COM_DISARM_PRFLT
        return 0.0 < limit_s <= time_s - self._since_s and not (self.has_flown and amid_mission)

    @property
    def text(self) -> str:
        """For the person on the ground."""
        return "Disarmed by landing" if self.has_flown else "Disarmed by auto preflight disarming"
