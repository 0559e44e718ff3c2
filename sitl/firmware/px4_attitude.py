"""PX4's multicopter attitude and rate controllers: attitude setpoint to normalised torque.

Attitude, 250 Hz: quaternion P with the yaw error scaled down, so that tilt comes first (Brescianini, Hehn,
D'Andrea, "Nonlinear Quadrocopter Attitude Control", ETH Zurich 2013). Rates, 1 kHz: PID with the derivative
on the low-passed measurement. PX4's modules `mc_att_control` and `mc_rate_control`.
"""

import math
from typing import NamedTuple

import numpy as np
from jaxtyping import Bool

from sitl.arrays import Quaternion, Vec3
from sitl.compiled import compiled
from sitl.firmware.px4_parameters import Px4Parameters
from sitl.firmware.px4_position import AttitudeSetpoint
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
    """PID in normalised torque, limit of the integral, low-pass of the derivative."""

    p: Vec3
    i: Vec3
    d: Vec3
    integral_limit: Vec3
    derivative_cutoff_hz: float


class RateState(NamedTuple):
    """Memory of the rate controller, in place.

    Attributes:
        setpoint: body rates that the attitude controller asks for (rad/s).
        integral: normalised torque.
        last_rates: rad/s.
        acceleration: low-passed derivative of the rates (rad/s²).
        short_up, short_down: axes on which the last allocation gave less, or more, torque than asked.
    """

    setpoint: Vec3
    integral: Vec3
    last_rates: Vec3
    acceleration: Vec3
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
        derivative_cutoff_hz=p.IMU_DGYRO_CUTOFF,
    )


def rate_state() -> RateState:
    """At rest, nothing integrated."""
    return RateState(*np.zeros((4, 3)), *np.zeros((2, 3), dtype=np.bool_))


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
def control_rates(gains: RateGains, state: RateState, rates: Vec3, hold_integral: bool, dt: float) -> Vec3:
    """Normalised torque; the integral stands still on the ground and where the rotors are at their limit."""
    tau = 1.0 / (2.0 * math.pi * gains.derivative_cutoff_hz)
    blend = dt / (tau + dt)
    torque = np.empty(3)
    for axis in range(3):
        raw = (rates[axis] - state.last_rates[axis]) / dt
        state.acceleration[axis] += blend * (raw - state.acceleration[axis])
        state.last_rates[axis] = rates[axis]
        error = state.setpoint[axis] - rates[axis]
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
    return torque
