"""How ArduPilot leaves and finds the ground: a takeoff that raises the throttle, and the land detector."""

import math
from enum import Enum, auto

from sitl.arrays import Vec3
from sitl.firmware.ardupilot_parameters import ArduPilotParameters

_LIFTED_THROTTLE = 0.9
_LIFTED_SPEED_SHARE = 0.1
"""A takeoff is in the air at this throttle, or at this share of WPNAV_SPEED_UP."""
_NO_THROTTLE = 0.01
_STILL_M_S = 1.0
_LANDED_AFTER_S = 1.0


class Phase(Enum):
    """Of a flight, as far as the throttle cares."""

    GROUND = auto()
    LIFTING = auto()  # the throttle is raised until the vehicle moves
    FLIGHT = auto()


class Takeoff:
    """Phases of a flight: GROUND, after `begin` LIFTING, in the air FLIGHT, and back when landed.

    Attributes:
        phase: the present one.
        elapsed_s: since it began, or since it was last entered anew.
    """

    def __init__(self, parameters: ArduPilotParameters) -> None:
        self._still_s = 0.0
        self.phase = Phase.GROUND
        self.elapsed_s = 0.0
        self.use(parameters)

    def use(self, parameters: ArduPilotParameters) -> None:
        """Go by these from now on."""
        self._parameters = parameters
        self._lifted_m_s = _LIFTED_SPEED_SHARE * 0.01 * parameters.WPNAV_SPEED_UP

    @property
    def open_throttle(self) -> float:
        """Throttle that no controller decides on: none on the ground, rising while lifting; NaN in flight."""
        if self.phase is Phase.FLIGHT:
            return math.nan
        if self.phase is Phase.GROUND:
            return 0.0
        p = self._parameters
        return min(max(0.0, self.elapsed_s - p.MOT_SPOOL_TIME) / p.TKOFF_SLEW_TIME, 1.0)

    def enter(self, phase: Phase) -> None:
        """Go to a phase, from its beginning."""
        self.phase = phase
        self.elapsed_s = self._still_s = 0.0

    def update(self, throttle: float, velocity: Vec3, dt: float) -> None:
        """Move on by `dt` (s); `throttle` (0 to 1) as it reaches the motors, `velocity` estimated (m/s)."""
        self.elapsed_s += dt
        if self.phase is Phase.LIFTING:
            if -velocity[2] > self._lifted_m_s or self.open_throttle >= _LIFTED_THROTTLE:
                self.enter(Phase.FLIGHT)
        elif self.phase is Phase.FLIGHT:
            speed = math.sqrt(velocity[0] ** 2 + velocity[1] ** 2 + velocity[2] ** 2)
            still = throttle < _NO_THROTTLE and speed < _STILL_M_S
            self._still_s = self._still_s + dt if still else 0.0
            if self._still_s >= _LANDED_AFTER_S:
                self.enter(Phase.GROUND)
