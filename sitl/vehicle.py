"""A vehicle as its YAML file describes it; see docs/vehicle-schema.md."""

import math
from pathlib import Path
from typing import Annotated, Literal, NamedTuple

import numpy as np
from jaxtyping import Float
from pydantic import BaseModel, ConfigDict, Field, PositiveFloat, model_validator

from sitl import files
from sitl.arrays import Array
from sitl.estimator_errors import EstimatorErrors
from sitl.files import KeyFaultError
from sitl.firmware.ardupilot_parameters import ArduPilotParameters
from sitl.firmware.px4_parameters import Px4Parameters

GRAVITY_M_S2 = 9.80665
MAX_HOVER_THRUST = 0.8
"""Share of the full thrust that hovering may take; PX4 allows MPC_THR_HOVER no more."""

_DEFAULT_THRUST_TO_WEIGHT = 2.0
_DEFAULT_DRAG_PER_S = 0.15
_DEFAULT_HOVER_TIME_S = 900.0
_DEFAULT_HOVER_SAG = 0.03

NonNegative3 = tuple[
    Annotated[float, Field(ge=0.0)], Annotated[float, Field(ge=0.0)], Annotated[float, Field(ge=0.0)]
]
Positive3 = tuple[PositiveFloat, PositiveFloat, PositiveFloat]


class MotionLimits(NamedTuple):
    """What a firmware keeps its vehicle to where it follows setpoints: m/s, m/s²."""

    up_m_s: float
    down_m_s: float
    acceleration_m_s2: float = math.inf
    vertical_acceleration_m_s2: float = math.inf


class _Section(BaseModel):
    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)


class RotorPlace(_Section):
    """Where a rotor sits in the body frame (forward, right, down from the centre of mass), and its sense."""

    x_m: float = Field(ge=-5.0, le=5.0)
    y_m: float = Field(ge=-5.0, le=5.0)
    z_m: float = Field(0.0, ge=-5.0, le=5.0)
    direction: Literal["cw", "ccw"]
    """Seen from above."""


class Rotors(_Section):
    """The rotors, all alike; thrust k ω² and drag torque of the same form."""

    layout: list[RotorPlace] = Field(min_length=4, max_length=12)
    thrust_coefficient_n_s2: float = Field(gt=0.0, le=1.0)
    """Thrust over speed squared, N/(rad/s)²."""
    moment_coefficient_nm_s2: float = Field(gt=0.0, le=1.0)
    """Drag torque over speed squared, N m/(rad/s)²."""
    max_speed_rad_s: float | None = Field(None, gt=0.0, le=1e5)
    """With a full battery; default: twice the thrust of hovering."""
    min_speed_rad_s: float = Field(0.0, ge=0.0)
    """Idle speed when armed."""
    time_constant_s: float = Field(0.02, ge=0.001, le=0.2)
    """First-order lag of the speed."""
    inertia_kg_m2: float = Field(0.0, ge=0.0, le=1.0)
    """Of one rotor with what turns along, about its axis."""
    delay_s: float = Field(0.0, ge=0.0, le=0.2)
    """From a command to the beginning of its effect, to whole milliseconds."""
    drag_coefficient_n_s2_per_m: float | None = Field(None, ge=0.0)
    """In-plane drag over speed and air-relative velocity, N/((rad/s)(m/s)); default: 0.15 1/s in hover."""


class BodyDrag(_Section):
    """Drag of the hull along each body axis, (linear + quadratic × airspeed) × velocity, and its damping."""

    linear_n_s_per_m: NonNegative3 = (0.0, 0.0, 0.0)
    quadratic_n_s2_per_m2: NonNegative3 = (0.0, 0.0, 0.0)
    angular_nm_s: NonNegative3 = (0.0, 0.0, 0.0)
    """Torque over body rate."""


class BatteryPack(_Section):
    """A battery whose voltage falls linearly with its charge; rotor speeds follow the voltage."""

    full_voltage_v: float = Field(12.6, gt=0.0)
    empty_voltage_v: float = Field(10.5, gt=0.0)
    capacity_ah: float | None = Field(None, gt=0.0)
    """Default: hovers for 15 minutes."""
    internal_resistance_ohm: float | None = Field(None, ge=0.0)
    """Default: sags by 3 % in hover."""
    drive_efficiency: float = Field(0.6, gt=0.0, le=1.0)
    """Shaft power over electric power."""

    @model_validator(mode="after")
    def _empties(self) -> "BatteryPack":
        if self.empty_voltage_v >= self.full_voltage_v:
            raise KeyFaultError("empty_voltage_v", "must be below full_voltage_v")
        return self


class Vehicle(_Section):
    """One file of `config/vehicles/`. Required: mass, inertia, rotor layout and coefficients."""

    name: str
    description: str = ""
    source: str = ""
    mass_kg: float = Field(ge=0.005, le=100.0)
    inertia_kg_m2: Positive3
    """About the body axes; products of inertia are taken as zero."""
    rotors: Rotors
    body_drag: BodyDrag = BodyDrag()
    battery: BatteryPack = BatteryPack()
    estimator: EstimatorErrors | None = None
    """Of its autopilot, where they were fitted to flights."""
    firmware: Literal["px4", "ardupilot"] = "px4"
    px4_parameters: Px4Parameters = Px4Parameters()
    """Only what differs; rate and attitude gains left out are tuned to the airframe, the rest is PX4's."""
    ardupilot_parameters: ArduPilotParameters = ArduPilotParameters()
    """The same for ArduPilot."""

    @model_validator(mode="after")
    def _can_fly(self) -> "Vehicle":
        x, y, z = sorted(self.inertia_kg_m2)
        if z > (x + y) * 1.001:
            raise KeyFaultError("inertia_kg_m2", "no rigid body has one moment above the sum of the others")
        if self.hover_thrust > MAX_HOVER_THRUST:
            raise KeyFaultError(
                "rotors.max_speed_rad_s",
                f"hovering would take {self.hover_thrust:.0%} of the full thrust, "
                f"more than {MAX_HOVER_THRUST:.0%}",
            )
        if self.rotors.min_speed_rad_s >= self.hover_speed_rad_s:
            raise KeyFaultError(
                "rotors.min_speed_rad_s",
                f"idling must be slower than hovering ({self.hover_speed_rad_s:.0f})",
            )
        effectiveness = self.rotor_effectiveness
        if np.linalg.matrix_rank(effectiveness) < 4 or np.linalg.pinv(effectiveness)[:, 3].min() <= 0.0:
            raise KeyFaultError(
                "rotors.layout", "these places and directions give no control of roll, pitch, yaw and thrust"
            )
        return self

    @property
    def hover_speed_rad_s(self) -> float:
        """Rotor speed at which the thrust carries the weight (rad/s)."""
        rotors = self.rotors
        return math.sqrt(self.mass_kg * GRAVITY_M_S2 / (len(rotors.layout) * rotors.thrust_coefficient_n_s2))

    @property
    def max_speed_rad_s(self) -> float:
        """Rotor speed with a full battery (rad/s)."""
        return self.rotors.max_speed_rad_s or math.sqrt(_DEFAULT_THRUST_TO_WEIGHT) * self.hover_speed_rad_s

    @property
    def hover_thrust(self) -> float:
        """Weight over full thrust."""
        return (self.hover_speed_rad_s / self.max_speed_rad_s) ** 2

    @property
    def motion_limits(self) -> MotionLimits:
        """What the firmware keeps the vehicle to; ArduPilot's parameters are in centimetres."""
        if self.firmware == "ardupilot":
            a = self.ardupilot_parameters
            in_cm = (a.WPNAV_SPEED_UP, a.WPNAV_SPEED_DN, a.WPNAV_ACCEL, a.WPNAV_ACCEL_Z)
            return MotionLimits(*(0.01 * limit for limit in in_cm))
        return MotionLimits(self.px4_parameters.MPC_Z_VEL_MAX_UP, self.px4_parameters.MPC_Z_VEL_MAX_DN)

    @property
    def rotor_effectiveness(self) -> Float[Array, "4 n"]:
        """Roll, pitch and yaw torque (N m) and thrust (N) of each rotor at full speed."""
        rotors = self.rotors
        full = rotors.thrust_coefficient_n_s2 * self.max_speed_rad_s**2
        arm = rotors.moment_coefficient_nm_s2 / rotors.thrust_coefficient_n_s2
        rows = [
            (-place.y_m, place.x_m, arm if place.direction == "ccw" else -arm, 1.0) for place in rotors.layout
        ]
        return full * np.array(rows).T

    @property
    def rotor_drag_n_s2_per_m(self) -> float:
        """In-plane drag of one rotor over its speed and its air-relative velocity."""
        given = self.rotors.drag_coefficient_n_s2_per_m
        if given is not None:
            return given
        return _DEFAULT_DRAG_PER_S * self.mass_kg / (len(self.rotors.layout) * self.hover_speed_rad_s)

    @property
    def hover_current_a(self) -> float:
        """Current with a full battery in hover (A)."""
        shaft_w = len(self.rotors.layout) * self.rotors.moment_coefficient_nm_s2 * self.hover_speed_rad_s**3
        return shaft_w / self.battery.drive_efficiency / self.battery.full_voltage_v

    @property
    def battery_charge_as(self) -> float:
        """Charge of a full battery (A s)."""
        capacity_ah = self.battery.capacity_ah
        return self.hover_current_a * _DEFAULT_HOVER_TIME_S if capacity_ah is None else capacity_ah * 3600.0

    @property
    def battery_resistance_ohm(self) -> float:
        """Internal resistance (Ω)."""
        given = self.battery.internal_resistance_ohm
        if given is not None:
            return given
        return _DEFAULT_HOVER_SAG * self.battery.full_voltage_v / self.hover_current_a


def load_vehicle(name_or_path: str | Path) -> Vehicle:
    """A vehicle by name ("bebop2") or path of a YAML file.

    Raises:
        ConfigError: unknown name, or a file that is wrong, with file, key and reason.
    """
    return files.load(Vehicle, "vehicles", name_or_path)
