"""Gains for an airframe that nobody has tuned: what a careful tuner would set in ArduPilot.

ArduPilot's rate gains turn rad/s into a share of the rotors' range, so the right ones depend on inertia,
rotors and arms. Here the rate loops are closed at a bandwidth that motors and gyro filter can follow.
"""

from sitl.firmware.ardupilot_motors import authority
from sitl.firmware.ardupilot_parameters import ArduPilotParameters
from sitl.vehicle import Vehicle

_MAX_RATE_BANDWIDTH = 20.0
_MAX_YAW_RATE_BANDWIDTH = 5.0
_LAG_PRODUCT = 0.6
"""Rate bandwidth times motor lag; less than PX4's, because ArduPilot's gyro filter is slower."""
_ANGLE_SHARE = 0.25
_LOW_CHARGE = 0.15


def tuned_parameters(vehicle: Vehicle) -> ArduPilotParameters:
    """The vehicle's own parameters; what depends on the airframe and is left out is fitted."""
    own = vehicle.ardupilot_parameters
    fitted = _fit(vehicle, ArduPilotParameters())
    return own.model_copy(
        update={name: value for name, value in fitted.items() if name not in own.model_fields_set}
    )


def _fit(vehicle: Vehicle, default: ArduPilotParameters) -> dict[str, float]:
    bandwidth = min(_MAX_RATE_BANDWIDTH, _LAG_PRODUCT / vehicle.rotors.time_constant_s)
    roll_authority, pitch_authority, yaw_authority = authority(vehicle).tolist()
    roll, pitch = bandwidth / roll_authority, bandwidth / pitch_authority
    yaw = min(bandwidth, _MAX_YAW_RATE_BANDWIDTH) / yaw_authority
    d_over_p = default.ATC_RAT_RLL_D / default.ATC_RAT_RLL_P
    angle = min(default.ATC_ANG_RLL_P, _ANGLE_SHARE * bandwidth)
    battery = vehicle.battery
    return {
        "MOT_THST_HOVER": vehicle.hover_thrust,
        "ATC_ANG_RLL_P": angle,
        "ATC_ANG_PIT_P": angle,
        "ATC_ANG_YAW_P": min(default.ATC_ANG_YAW_P, _ANGLE_SHARE * yaw * yaw_authority * 2.0),
        "ATC_RAT_RLL_P": roll,
        "ATC_RAT_RLL_I": roll,
        "ATC_RAT_RLL_D": d_over_p * roll,
        "ATC_RAT_PIT_P": pitch,
        "ATC_RAT_PIT_I": pitch,
        "ATC_RAT_PIT_D": d_over_p * pitch,
        "ATC_RAT_YAW_P": yaw,
        "ATC_RAT_YAW_I": 0.1 * yaw,
        "BATT_LOW_VOLT": battery.empty_voltage_v
        + _LOW_CHARGE * (battery.full_voltage_v - battery.empty_voltage_v),
    }
