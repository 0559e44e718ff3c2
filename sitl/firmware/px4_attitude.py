"""PX4's multicopter attitude and rate controllers: attitude setpoint to normalised torque.

Attitude, 250 Hz: quaternion P with the yaw error scaled down, so that tilt comes first (Brescianini, Hehn,
D'Andrea, "Nonlinear Quadrocopter Attitude Control", ETH Zurich 2013). Rates, 1 kHz: PID with the derivative
on the measurement, the gyro and the yaw torque low-passed. PX4's modules `mc_att_control`,
`mc_rate_control` and `sensors` (vehicle_angular_velocity).
"""

import math
from typing import NamedTuple

import numpy as np
from jaxtyping import Bool, Float

from sitl.arrays import Array, Quaternion, Vec3
from sitl.compiled import compiled
from sitl.firmware.px4_filters import LowPass2, blend, low_pass_2
from sitl.firmware.px4_parameters import Px4Parameters
from sitl.firmware.px4_position import AttitudeSetpoint
from sitl.plant import STEP_S
from sitl.quaternion import conjugate, multiply, rotate_back

_I_FADE_RATE = math.radians(400.0)
"""Rate error at which the integral gain has faded to zero."""

Flags3 = Bool[np.ndarray[tuple[int, ...], np.dtype[np.bool_]], "3"]


class AttitudeGains(NamedTuple):
    """Attitude P (1/s), weight of yaw (0 to 1), limits of the rate setpoint (rad/s)."""

    p: Vec3
    yaw_weight: float
    max_rates: Vec3


class RateGains(NamedTuple):
    """PID in normalised torque, limit of the integral, low passes of gyro, derivative and yaw torque."""

    p: Vec3
    i: Vec3
    d: Vec3
    integral_limit: Vec3
    gyro_filter: LowPass2
    derivative_cutoff_hz: float
    yaw_torque_cutoff_hz: float


class RateState(NamedTuple):
    """Memory of the rate controller, in place.

    Attributes:
        setpoint: body rates that the attitude controller asks for (rad/s).
        integral: normalised torque.
        gyro: of the two steps before, newest first (rad/s).
        rates: the same, low-passed.
        acceleration: derivative of the low-passed rates, low-passed once more (rad/s²).
        yaw_torque: normalised, low-passed.
        short_up, short_down: axes on which the last allocation gave less, or more, torque than asked.
    """

    setpoint: Vec3
    integral: Vec3
    gyro: Float[Array, "2 3"]
    rates: Float[Array, "2 3"]
    acceleration: Vec3
    yaw_torque: Float[Array, "1"]
    short_up: Flags3
    short_down: Flags3


def attitude_gains(p: Px4Parameters) -> AttitudeGains:
    """Gains from PX4 parameters."""
    return AttitudeGains(
        p=np.array((p.MC_ROLL_P, p.MC_PITCH_P, p.MC_YAW_P)),
        yaw_weight=p.MC_YAW_WEIGHT,
        max_rates=np.radians((p.MC_ROLLRATE_MAX, p.MC_PITCHRATE_MAX, p.MC_YAWRATE_MAX)),
    )


def rate_gains(p: Px4Parameters) -> RateGains:
    """Gains from PX4 parameters."""
    return RateGains(
        p=np.array((p.MC_ROLLRATE_P, p.MC_PITCHRATE_P, p.MC_YAWRATE_P)),
        i=np.array((p.MC_ROLLRATE_I, p.MC_PITCHRATE_I, p.MC_YAWRATE_I)),
        d=np.array((p.MC_ROLLRATE_D, p.MC_PITCHRATE_D, p.MC_YAWRATE_D)),
        integral_limit=np.array((p.MC_RR_INT_LIM, p.MC_PR_INT_LIM, p.MC_YR_INT_LIM)),
        gyro_filter=low_pass_2(p.IMU_GYRO_CUTOFF, STEP_S),
        derivative_cutoff_hz=p.IMU_DGYRO_CUTOFF,
        yaw_torque_cutoff_hz=p.MC_YAW_TQ_CUTOFF,
    )


def rate_state() -> RateState:
    """At rest, nothing integrated."""
    return RateState(
        setpoint=np.zeros(3),
        integral=np.zeros(3),
        gyro=np.zeros((2, 3)),
        rates=np.zeros((2, 3)),
        acceleration=np.zeros(3),
        yaw_torque=np.zeros(1),
        short_up=np.zeros(3, dtype=np.bool_),
        short_down=np.zeros(3, dtype=np.bool_),
    )


def begin_turning(state: RateState, rates: Vec3) -> None:
    """Let the filters begin at steady `rates` (rad/s)."""
    state.gyro[:] = rates
    state.rates[:] = rates


@compiled
def tilt_first(q: Quaternion, target: Quaternion, yaw_weight: float) -> Quaternion:
    """The rotation (body frame) from `q` to `target` with only a share of its yaw.

    The full rotation is split into one about an axis in the body's x-y plane, which aligns the thrust,
    followed by one about z; the second is scaled.
    """
    error = multiply(conjugate(q), target)
    if error[0] < 0.0:
        error = -error
    length = math.hypot(error[0], error[3])
    if length < 1e-6:  # upside down: which way to yaw has no meaning
        return error
    half_yaw = math.atan2(error[3], error[0])
    turn = np.array((error[0] / length, 0.0, 0.0, error[3] / length))
    tilt = multiply(error, conjugate(turn))
    scaled = np.array((math.cos(yaw_weight * half_yaw), 0.0, 0.0, math.sin(yaw_weight * half_yaw)))
    return multiply(tilt, scaled)


@compiled
def control_attitude(
    gains: AttitudeGains, setpoint: AttitudeSetpoint, attitude: Quaternion, state: RateState
) -> None:
    """Rate setpoint 2 P Im(q_e), with the commanded yaw rate fed forward, limited on each axis."""
    error = tilt_first(attitude, setpoint.attitude, gains.yaw_weight)
    sign = 1.0 if error[0] >= 0.0 else -1.0
    turn = rotate_back(attitude, (0.0, 0.0, setpoint.thrust_and_yaw_rate[1]))
    for axis in range(3):
        p = gains.p[axis]
        if axis == 2 and gains.yaw_weight > 1e-4:
            p /= gains.yaw_weight
        rate = 2.0 * sign * p * error[1 + axis] + turn[axis]
        state.setpoint[axis] = min(max(rate, -gains.max_rates[axis]), gains.max_rates[axis])


@compiled
def filter_gyro(gains: RateGains, state: RateState, gyro: Vec3, dt: float) -> None:
    """Move the low-passed rates and their low-passed derivative on by a measurement of the gyro."""
    f, raw, rates = gains.gyro_filter, state.gyro, state.rates
    fresh = blend(gains.derivative_cutoff_hz, dt)
    for axis in range(3):
        rate = f.b0 * gyro[axis] + f.b1 * raw[0, axis] + f.b2 * raw[1, axis]
        rate -= f.a1 * rates[0, axis] + f.a2 * rates[1, axis]
        state.acceleration[axis] += fresh * ((rate - rates[0, axis]) / dt - state.acceleration[axis])
        raw[1, axis], raw[0, axis] = raw[0, axis], gyro[axis]
        rates[1, axis], rates[0, axis] = rates[0, axis], rate


@compiled
def control_rates(gains: RateGains, state: RateState, gyro: Vec3, hold_integral: bool, dt: float) -> Vec3:
    """Normalised torque; the integral stands still on the ground and where the rotors are at their limit."""
    filter_gyro(gains, state, gyro, dt)
    torque = np.empty(3)
    for axis in range(3):
        error = state.setpoint[axis] - state.rates[0, axis]
        torque[axis] = gains.p[axis] * error + state.integral[axis] - gains.d[axis] * state.acceleration[axis]
        if hold_integral:
            state.integral[axis] = 0.0
            continue
        if state.short_up[axis]:
            error = min(error, 0.0)
        if state.short_down[axis]:
            error = max(error, 0.0)
        fade = max(0.0, 1.0 - (error / _I_FADE_RATE) ** 2)
        limit = gains.integral_limit[axis]
        state.integral[axis] = min(
            max(state.integral[axis] + fade * gains.i[axis] * error * dt, -limit), limit
        )
    state.yaw_torque[0] += blend(gains.yaw_torque_cutoff_hz, dt) * (torque[2] - state.yaw_torque[0])
    torque[2] = state.yaw_torque[0]
    return torque
