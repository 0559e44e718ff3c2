"""What every simulated autopilot offers: the seam between flight control and the MAVLink face.

The firmware knows no MAVLink; the MAVLink face knows no control law. NED, SI, radians.
"""

from dataclasses import dataclass, field
from enum import Enum, auto
from typing import Protocol

import numpy as np

from sitl.arrays import Quaternion, Vec3
from sitl.estimator import CONTENT
from sitl.firmware.parameters import Parameters
from sitl.firmware.pilot import Sticks
from sitl.plan.plans import Plans
from sitl.plant import Plant, TickNoise

_OFF = float("nan")


class Mode(Enum):
    """Flight modes, by their PX4 names; BRAKE is ArduPilot's, STABILIZE both have."""

    POSCTL = auto()
    ALTCTL = auto()
    HOLD = auto()  # AUTO.LOITER
    TAKEOFF = auto()
    LAND = auto()
    RTL = auto()
    MISSION = auto()
    OFFBOARD = auto()
    STABILIZE = auto()  # in which ArduPilot boots
    BRAKE = auto()  # a hold without pilot


class Landed(Enum):
    """Where the vehicle is, as its land detector has it (MAV_LANDED_STATE)."""

    ON_GROUND = auto()
    IN_AIR = auto()
    TAKING_OFF = auto()
    LANDING = auto()


class Result(Enum):
    """How the firmware answers a request (MAV_RESULT)."""

    ACCEPTED = auto()
    TEMPORARILY_REJECTED = auto()
    DENIED = auto()
    FAILED = auto()


class Severity(Enum):
    """How grave a status text is (MAV_SEVERITY)."""

    CRITICAL = 2
    WARNING = 4
    INFO = 6


@dataclass(frozen=True, slots=True)
class StatusText:
    """One line for the person on the ground."""

    severity: Severity
    text: str


def _off() -> Vec3:
    return np.full(3, _OFF)


@dataclass(frozen=True, slots=True, eq=False)
class Setpoint:
    """An offboard setpoint: NaN switches an axis of a channel off, as PX4's trajectory_setpoint has it.

    Attributes:
        position: NED (m).
        velocity: NED (m/s).
        acceleration: NED (m/s²).
        yaw: rad. yaw_rate: rad/s.
    """

    position: Vec3 = field(default_factory=_off)
    velocity: Vec3 = field(default_factory=_off)
    acceleration: Vec3 = field(default_factory=_off)
    yaw: float = _OFF
    yaw_rate: float = _OFF


@dataclass(frozen=True, slots=True, eq=False)
class AttitudeTarget:
    """What attitude and rate control follow.

    Attributes:
        attitude: unit quaternion.
        rates: body rates p, q, r (rad/s).
        thrust: collective, 0 to 1.
    """

    attitude: Quaternion
    rates: Vec3
    thrust: float


@dataclass(frozen=True, slots=True, eq=False)
class Estimate:
    """The firmware's own estimate, which it flies on and reports; never the truth.

    Attributes:
        time_s: time since boot (s).
        position, velocity, acceleration: NED (m, m/s, m/s²).
        attitude: unit quaternion.
        rates: body rates p, q, r (rad/s).
        gps: where the GPS receiver has the vehicle; NED (m).
        resets: how often position and velocity jumped.
        test_ratios: of velocity and heading; from 1 on its sensors are refused.
    """

    time_s: float
    position: Vec3
    velocity: Vec3
    acceleration: Vec3
    attitude: Quaternion
    rates: Vec3
    gps: Vec3
    resets: int = 0
    test_ratios: tuple[float, float] = (CONTENT, CONTENT)


@dataclass(frozen=True, slots=True)
class Battery:
    """Voltage (V), current (A), remaining charge (0 to 1)."""

    voltage_v: float
    current_a: float
    remaining: float


@dataclass(frozen=True, slots=True)
class Health:
    """What arming, SYS_STATUS and the estimator's own report ask for."""

    sensors_ok: bool
    gps_ok: bool
    position_ok: bool
    ready_to_arm: bool


@dataclass(frozen=True, slots=True)
class FenceStatus:
    """Of the fence: whether it is minded, which limit is broken now, how often, and since when (s).

    `breach` is empty, or one of "altitude", "distance", "boundary".
    """

    enabled: bool = False
    breach: str = ""
    count: int = 0
    since_s: float = 0.0


class Autopilot(Protocol):
    """A simulated autopilot as its peers know it; time moves only in `Simulation.advance`."""

    @property
    def estimate(self) -> Estimate:
        """What the firmware believes at this instant."""
        ...

    @property
    def active_setpoint(self) -> Setpoint:
        """What the position controller follows now, in any mode."""
        ...

    @property
    def attitude_target(self) -> AttitudeTarget:
        """What attitude and rate control follow now."""
        ...

    @property
    def mode(self) -> Mode:
        """The mode that flies now, a failsafe's included."""
        ...

    @property
    def intended_mode(self) -> Mode:
        """The mode that was chosen last, or that follows from that one, whatever a failsafe made of it."""
        ...

    @property
    def armed(self) -> bool:
        """Whether the rotors may turn."""
        ...

    @property
    def landed(self) -> Landed:
        """As the land detector has it."""
        ...

    @property
    def failsafe(self) -> bool:
        """Whether a failsafe chose the present mode."""
        ...

    @property
    def battery(self) -> Battery:
        """As measured."""
        ...

    @property
    def health(self) -> Health:
        """Of sensors and estimate, and whether arming would be accepted."""
        ...

    @property
    def position_ok(self) -> bool:
        """Whether it knows where it is."""
        ...

    @property
    def parameters(self) -> Parameters:
        """What it flies by now, under the autopilot's own names."""
        ...

    def set_parameter(self, name: str, value: float) -> None:
        """Fly by another value from now on.

        Raises:
            ParameterRefusedError: an unknown name, or a value that it may not have.
        """
        ...

    def arm(self, *, force: bool = False) -> Result:
        """Arm, unless a check refuses; forced, without checks."""
        ...

    def check(self) -> Result:
        """Look for reasons not to arm (MAV_CMD_RUN_PREARM_CHECKS)."""
        ...

    def disarm(self, *, force: bool = False) -> Result:
        """Refused in the air unless forced."""
        ...

    def set_mode(self, mode: Mode) -> Result:
        """Change the mode, unless its conditions are not met."""
        ...

    def terminate(self) -> Result:
        """Stop the rotors, in the air too, for good (MAV_CMD_DO_FLIGHTTERMINATION)."""
        ...

    def hear_ground_station(self, system_id: int) -> None:
        """A heartbeat of a ground station came now."""
        ...

    def move_sticks(self, sticks: Sticks) -> None:
        """The pilot's sticks are there now."""
        ...

    def hear_satellites(self, *, heard: bool) -> None:
        """Whether the receiver has a fix now."""
        ...

    def turn(self, yaw: float) -> Result:
        """Turn to a heading (rad) while the path stays (MAV_CMD_CONDITION_YAW)."""
        ...

    def takeoff(self, altitude_m: float | None = None) -> Result:
        """Climb to `altitude_m` (m) and hold there.

        PX4: above the present height, MIS_TAKEOFF_ALT when None. ArduPilot: above home, from GUIDED.
        """
        ...

    def reposition(self, position: Vec3, yaw: float) -> Result:
        """Hold mode at another place (MAV_CMD_DO_REPOSITION); NaN keeps what is."""
        ...

    def offboard_setpoint(self, setpoint: Setpoint) -> None:
        """A setpoint arrived now; proof of life even when another mode is active."""
        ...

    @property
    def plans(self) -> Plans:
        """Mission, fence and rally points on board, home, and how far the mission is."""
        ...

    @property
    def fence_status(self) -> FenceStatus:
        """Whether the fence is on, and broken."""
        ...

    def start_mission(self, first: int | None = None) -> Result:
        """Fly the mission, from item `first` or where it is (MAV_CMD_MISSION_START)."""
        ...

    def change_speed(self, speed_m_s: float) -> Result:
        """Fly the present legs, and those of a mission, at this ground speed (MAV_CMD_DO_CHANGE_SPEED)."""
        ...

    def enable_fence(self, *, enabled: bool) -> Result:
        """Mind the fence, or no longer (MAV_CMD_DO_FENCE_ENABLE)."""
        ...

    def take_status_texts(self) -> list[StatusText]:
        """The texts since the last call, oldest first: reasons of refusals, failsafes, mode changes."""
        ...


class Firmware(Autopilot, Protocol):
    """A simulated autopilot as the simulation drives it."""

    def wait_for_position(self, until_s: float) -> None:
        """Have no position before this time (s)."""
        ...

    def begin_in_flight(self) -> None:
        """Fly already, armed, in the mode that follows setpoints; the estimate says where."""
        ...

    def fly_tick(self, plant: Plant, first_step: int, noise: TickNoise) -> None:
        """Control the plant and move it on by one tick; `first_step` counts steps since boot."""
        ...
