"""The kinds of fault as plain data: what goes wrong, when, and for how long."""

from enum import StrEnum
from typing import Annotated, ClassVar, Literal, TypeAlias, get_args

from pydantic import BaseModel, ConfigDict, Field

Share = Annotated[float, Field(ge=0.0, le=1.0)]
Speed = Annotated[float, Field(ge=-50.0, le=50.0)]
Length = Annotated[float, Field(ge=-1e4, le=1e4)]
Delay = Annotated[float, Field(ge=0.0, le=60.0)]
Deflection = Annotated[float, Field(ge=-1.0, le=1.0)]


class Phase(StrEnum):
    """What a fault may wait for; each begins once, and a fault counts from its beginning."""

    BOOT = "boot"
    TAKEOFF = "takeoff"
    """The vehicle has left the ground."""
    SETPOINTS = "setpoints"
    """It is in the air, in the mode that follows setpoints."""
    LANDING = "landing"
    """It lands or returns, by command or by a failsafe."""


class _Fault(BaseModel):
    """What all faults have."""

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)
    meaning: ClassVar[str]

    after: Phase = Phase.BOOT
    at_s: float = Field(0.0, ge=0.0)
    """Seconds after that phase has begun."""
    lasts_s: float | None = Field(None, gt=0.0)
    """Default: for good."""


class MotorWeak(_Fault):
    """A rotor has this share of its thrust and drag torque; rotors count from 1, as the file has them."""

    meaning = "a rotor gives a part of its thrust"
    kind: Literal["motor_weak"] = "motor_weak"
    motor: int = Field(ge=1, le=12)
    effectiveness: Share


class MotorDead(_Fault):
    """A rotor has stopped."""

    meaning = "a rotor gives no thrust"
    kind: Literal["motor_dead"] = "motor_dead"
    motor: int = Field(ge=1, le=12)


class RotorsStopped(_Fault):
    """Somebody pressed the kill switch (MAV_CMD_DO_FLIGHTTERMINATION)."""

    meaning = "the kill switch stops all rotors"
    kind: Literal["rotors_stopped"] = "rotors_stopped"


class Gust(_Fault):
    """Added to the wind: it rises and ends over `rise_s` as 1 - cos (MIL-F-8785C, section 3.7.1.3)."""

    meaning = "a discrete gust"
    kind: Literal["gust"] = "gust"
    north_m_s: Speed = 0.0
    east_m_s: Speed = 0.0
    down_m_s: Speed = 0.0
    rise_s: float = Field(0.5, gt=0.0, le=60.0)


class BatteryCollapse(_Fault):
    """The charge falls to this share at once, and the voltage with it; it does not come back."""

    meaning = "the battery's charge is suddenly this low"
    kind: Literal["battery_collapse"] = "battery_collapse"
    remaining: Share


class GpsLost(_Fault):
    """The estimate drifts off by an acceleration error until the autopilot declares its position lost."""

    meaning = "no satellites: the estimate drifts, then the autopilot has no position"
    kind: Literal["gps_lost"] = "gps_lost"
    north_m_s2: float = Field(0.05, ge=-5.0, le=5.0)
    east_m_s2: float = Field(0.0, ge=-5.0, le=5.0)


class EstimatorJump(_Fault):
    """The estimated position is wrong by this, at once; `announced`: counted as a reset."""

    meaning = "the estimated position jumps"
    kind: Literal["estimator_jump"] = "estimator_jump"
    north_m: Length = 0.0
    east_m: Length = 0.0
    down_m: Length = 0.0
    announced: bool = True


class EstimatorDrift(_Fault):
    """The estimated position runs away at this speed, and its velocity does not show it."""

    meaning = "the estimated position drifts"
    kind: Literal["estimator_drift"] = "estimator_drift"
    north_m_s: Speed = 0.0
    east_m_s: Speed = 0.0
    down_m_s: Speed = 0.0


class VelocityError(_Fault):
    """The estimated velocity is wrong by this."""

    meaning = "the estimated velocity is wrong"
    kind: Literal["velocity_error"] = "velocity_error"
    north_m_s: Speed = 0.0
    east_m_s: Speed = 0.0
    down_m_s: Speed = 0.0


class CompassError(_Fault):
    """The estimated heading is wrong by this, about the world's down axis."""

    meaning = "the estimated heading is wrong"
    kind: Literal["compass_error"] = "compass_error"
    error_deg: float = Field(ge=-180.0, le=180.0)


class Reboot(_Fault):
    """The autopilot starts anew: disarmed, in the air too."""

    meaning = "the autopilot reboots"
    kind: Literal["reboot"] = "reboot"


class PilotMode(_Fault):
    """The pilot switches to a mode on the remote control, sticks in the middle.

    The names are PX4's; ArduPilot has LOITER for both POSCTL and HOLD.
    """

    meaning = "the pilot switches to a mode"
    kind: Literal["pilot_mode"] = "pilot_mode"
    mode: Literal["POSCTL", "ALTCTL", "STABILIZE", "HOLD", "LAND", "RTL"] = "POSCTL"


class PilotSticks(_Fault):
    """The pilot moves the sticks: right, forward, up, clockwise."""

    meaning = "the pilot moves the sticks"
    kind: Literal["pilot_sticks"] = "pilot_sticks"
    roll: Deflection = 0.0
    pitch: Deflection = 0.0
    climb: Deflection = 0.0
    yaw: Deflection = 0.0


class SetpointsIgnored(_Fault):
    """The autopilot counts the setpoints that arrive, and flies to the one that it had before."""

    meaning = "setpoints are heard but not followed"
    kind: Literal["setpoints_ignored"] = "setpoints_ignored"


class TelemetryLost(_Fault):
    """Nothing that the vehicle sends arrives."""

    meaning = "nothing from the vehicle arrives"
    kind: Literal["telemetry_lost"] = "telemetry_lost"


class TelemetryFrozen(_Fault):
    """Position, velocity and attitude stay as they were, with times that go on."""

    meaning = "the state that is told stands still, its times do not"
    kind: Literal["telemetry_frozen"] = "telemetry_frozen"


class TelemetryLate(_Fault):
    """What the vehicle sends arrives this much later, give or take `jitter_s`."""

    meaning = "what the vehicle sends is late"
    kind: Literal["telemetry_late"] = "telemetry_late"
    delay_s: Delay
    jitter_s: Delay = 0.0


class TelemetryLossy(_Fault):
    """This share of the vehicle's frames is lost."""

    meaning = "a share of the vehicle's frames is lost"
    kind: Literal["telemetry_lossy"] = "telemetry_lossy"
    share: Share


class TelemetryDuplicated(_Fault):
    """This share of the vehicle's frames comes twice."""

    meaning = "a share of the vehicle's frames comes twice"
    kind: Literal["telemetry_duplicated"] = "telemetry_duplicated"
    share: Share


class TelemetryReordered(_Fault):
    """This share of the vehicle's frames comes behind later ones."""

    meaning = "a share of the vehicle's frames comes out of order"
    kind: Literal["telemetry_reordered"] = "telemetry_reordered"
    share: Share


class TelemetryCorrupted(_Fault):
    """In this share of the vehicle's frames a few bytes are others."""

    meaning = "a share of the vehicle's frames is damaged"
    kind: Literal["telemetry_corrupted"] = "telemetry_corrupted"
    share: Share


class MessageLost(_Fault):
    """The vehicle streams this message no more."""

    meaning = "one message of the vehicle stays away"
    kind: Literal["message_lost"] = "message_lost"
    message: str = Field(pattern="^[A-Z][A-Z0-9_]*$")


class ClockJump(_Fault):
    """The times in the vehicle's messages are off by this."""

    meaning = "the vehicle's clock is wrong"
    kind: Literal["clock_jump"] = "clock_jump"
    step_s: float = Field(ge=-3600.0, le=3600.0)


class UplinkLost(_Fault):
    """Nothing that is sent to the vehicle arrives."""

    meaning = "nothing to the vehicle arrives"
    kind: Literal["uplink_lost"] = "uplink_lost"


class UplinkLate(_Fault):
    """What is sent to the vehicle arrives this much later, give or take `jitter_s`."""

    meaning = "what is sent to the vehicle is late"
    kind: Literal["uplink_late"] = "uplink_late"
    delay_s: Delay
    jitter_s: Delay = 0.0


class UplinkLossy(_Fault):
    """This share of the frames to the vehicle is lost."""

    meaning = "a share of the frames to the vehicle is lost"
    kind: Literal["uplink_lossy"] = "uplink_lossy"
    share: Share


class LinkLost(_Fault):
    """Nothing arrives, either way."""

    meaning = "nothing arrives, either way"
    kind: Literal["link_lost"] = "link_lost"


Fault: TypeAlias = (
    MotorWeak
    | MotorDead
    | RotorsStopped
    | Gust
    | BatteryCollapse
    | GpsLost
    | EstimatorJump
    | EstimatorDrift
    | VelocityError
    | CompassError
    | Reboot
    | PilotMode
    | PilotSticks
    | SetpointsIgnored
    | TelemetryLost
    | TelemetryFrozen
    | TelemetryLate
    | TelemetryLossy
    | TelemetryDuplicated
    | TelemetryReordered
    | TelemetryCorrupted
    | MessageLost
    | ClockJump
    | UplinkLost
    | UplinkLate
    | UplinkLossy
    | LinkLost
)

KINDS: dict[str, type[_Fault]] = {model.model_fields["kind"].default: model for model in get_args(Fault)}
"""The model of each kind, by its name."""
COMMON = tuple(_Fault.model_fields)
"""What every kind has."""
