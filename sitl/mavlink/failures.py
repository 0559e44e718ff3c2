"""MAV_CMD_INJECT_FAILURE, which PX4 knows: faults that a peer asks for.

Units, types and answers as https://docs.px4.io/main/en/debug/failure_injection.html and PX4's module
`failure_injection` have them; ArduPilot has no such command.
"""

from collections.abc import Callable, Iterable
from typing import TYPE_CHECKING

from pymavlink.dialects.v20 import common as mavlink

from sitl.faults import kinds
from sitl.mavlink.commands import Command, whole

if TYPE_CHECKING:
    from sitl.mavlink.session import Session

_REFUSED_DRIFT_M_S2 = 0.2
"""A receiver that stands still or lies is refused by the estimator, after it has been believed a little."""
_WRONG_COMPASS_DEG = 90.0
_DELAY_S = 1.0
_SHARE = 0.5

_OFF, _STUCK, _WRONG = mavlink.FAILURE_TYPE_OFF, mavlink.FAILURE_TYPE_STUCK, mavlink.FAILURE_TYPE_WRONG
_Make = Callable[[int], kinds.Fault]
"""Makes the fault of one instance."""

_FAULTS: dict[tuple[int, int], _Make] = {
    (mavlink.FAILURE_UNIT_SYSTEM_MOTOR, _OFF): lambda motor: kinds.MotorDead(motor=motor),
    (mavlink.FAILURE_UNIT_SENSOR_GPS, _OFF): lambda _: kinds.GpsLost(),
    (mavlink.FAILURE_UNIT_SENSOR_GPS, _STUCK): lambda _: kinds.GpsLost(north_m_s2=_REFUSED_DRIFT_M_S2),
    (mavlink.FAILURE_UNIT_SENSOR_GPS, _WRONG): lambda _: kinds.GpsLost(north_m_s2=_REFUSED_DRIFT_M_S2),
    (mavlink.FAILURE_UNIT_SENSOR_MAG, _WRONG): lambda _: kinds.CompassError(error_deg=_WRONG_COMPASS_DEG),
    (mavlink.FAILURE_UNIT_SYSTEM_BATTERY, _OFF): lambda _: kinds.BatteryCollapse(remaining=0.0),
    (mavlink.FAILURE_UNIT_SYSTEM_MAVLINK_SIGNAL, _OFF): lambda _: kinds.LinkLost(),
    (mavlink.FAILURE_UNIT_SYSTEM_MAVLINK_SIGNAL, mavlink.FAILURE_TYPE_DELAYED): lambda _: kinds.TelemetryLate(
        delay_s=_DELAY_S
    ),
    (mavlink.FAILURE_UNIT_SYSTEM_MAVLINK_SIGNAL, mavlink.FAILURE_TYPE_INTERMITTENT): lambda _: (
        kinds.TelemetryLossy(share=_SHARE)
    ),
}
_CONCERNED: dict[int, tuple[type[kinds.Fault], ...]] = {
    mavlink.FAILURE_UNIT_SYSTEM_MOTOR: (kinds.MotorDead, kinds.MotorWeak),
    mavlink.FAILURE_UNIT_SENSOR_GPS: (kinds.GpsLost,),
    mavlink.FAILURE_UNIT_SENSOR_MAG: (kinds.CompassError,),
    mavlink.FAILURE_UNIT_SYSTEM_BATTERY: (kinds.BatteryCollapse,),
    mavlink.FAILURE_UNIT_SYSTEM_MAVLINK_SIGNAL: (
        kinds.LinkLost,
        kinds.TelemetryLate,
        kinds.TelemetryLossy,
    ),
}
"""What FAILURE_TYPE_OK ends."""


def inject(session: "Session", command: Command) -> int:
    """Let a unit fail, or be well again, where SYS_FAILURE_EN is 1; instance 0 is all there are."""
    if not getattr(session.firmware.parameters, "SYS_FAILURE_EN", 0):
        return mavlink.MAV_RESULT_DENIED
    unit, type_, instance = (whole(value) for value in command.params[:3])
    instances = _instances(unit, instance, session.rotors)
    make = _FAULTS.get((unit, type_))
    if not instances or not (make or (type_ == mavlink.FAILURE_TYPE_OK and unit in _CONCERNED)):
        return mavlink.MAV_RESULT_UNSUPPORTED
    session.faults.clear(lambda fault: _concerns(fault, unit, instances))
    if make:
        for each in instances:
            session.faults.inject(make(each))
    return mavlink.MAV_RESULT_ACCEPTED


def _instances(unit: int, instance: int, rotors: int) -> range:
    count = rotors if unit == mavlink.FAILURE_UNIT_SYSTEM_MOTOR else 1
    if instance == 0:
        return range(1, count + 1)
    return range(instance, instance + 1) if 0 < instance <= count else range(0)


def _concerns(fault: kinds.Fault, unit: int, instances: Iterable[int]) -> bool:
    return isinstance(fault, _CONCERNED[unit]) and getattr(fault, "motor", 1) in instances
