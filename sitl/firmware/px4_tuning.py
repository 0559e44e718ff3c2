"""Gains for an airframe that nobody has tuned: what a careful tuner would set in place of PX4's defaults.

PX4's rate gains are in normalised torque, so the right ones depend on inertia, rotors and arms. Here the
rate loops are closed at a bandwidth that the motors can follow, and the attitude loop below it.
"""

from sitl.firmware.px4_allocation import allocation
from sitl.firmware.px4_parameters import Px4Parameters
from sitl.vehicle import Vehicle

_MAX_RATE_BANDWIDTH = 25.0
_MAX_YAW_RATE_BANDWIDTH = 8.0
_LAG_PRODUCT = 0.8
"""Rate bandwidth times motor lag: a damping ratio of about 0.6 before the derivative adds its own."""
_ATTITUDE_SHARE = 0.35
_MAX_YAW_RATE_P = 0.6


def tuned_parameters(vehicle: Vehicle) -> Px4Parameters:
    """The vehicle's own parameters; hover thrust, rate and attitude gains that it leaves out are fitted."""
    own = vehicle.px4_parameters
    fitted = _fit(vehicle, Px4Parameters())
    return own.model_copy(
        update={name: value for name, value in fitted.items() if name not in own.model_fields_set}
    )


def _fit(vehicle: Vehicle, default: Px4Parameters) -> dict[str, float]:
    # Angular acceleration of a unit of normalised torque, rad/s².
    authority = (allocation(vehicle).torque / vehicle.inertia_kg_m2).tolist()
    bandwidth = min(_MAX_RATE_BANDWIDTH, _LAG_PRODUCT / vehicle.rotors.time_constant_s)
    roll, pitch = bandwidth / authority[0], bandwidth / authority[1]
    yaw = min(min(bandwidth, _MAX_YAW_RATE_BANDWIDTH) / authority[2], _MAX_YAW_RATE_P)
    attitude = min(default.MC_ROLL_P, _ATTITUDE_SHARE * bandwidth)
    i_over_p = default.MC_ROLLRATE_I / default.MC_ROLLRATE_P
    d_over_p = default.MC_ROLLRATE_D / default.MC_ROLLRATE_P
    return {
        "MPC_THR_HOVER": vehicle.hover_thrust,
        "MPC_THR_MIN": min(default.MPC_THR_MIN, 0.25 * vehicle.hover_thrust),
        "MC_ROLL_P": attitude,
        "MC_PITCH_P": attitude,
        "MC_YAW_P": min(default.MC_YAW_P, _ATTITUDE_SHARE * yaw * authority[2]),
        "MC_ROLLRATE_P": roll,
        "MC_ROLLRATE_I": i_over_p * roll,
        "MC_ROLLRATE_D": d_over_p * roll,
        "MC_PITCHRATE_P": pitch,
        "MC_PITCHRATE_I": i_over_p * pitch,
        "MC_PITCHRATE_D": d_over_p * pitch,
        "MC_YAWRATE_P": yaw,
        "MC_YAWRATE_I": default.MC_YAWRATE_I / default.MC_YAWRATE_P * yaw,
    }
