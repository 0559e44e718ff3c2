"""ArduPilot's attitude and rate controllers: lean and heading to roll, pitch and yaw output, 400 Hz.

A target attitude follows the command within angular acceleration and is fed forward; what the vehicle is
off it is corrected through square-root controllers, thrust direction first, heading after
(`libraries/AC_AttitudeControl/AC_AttitudeControl.cpp`, `input_thrust_vector_heading`).
"""

import math
from typing import NamedTuple

import numpy as np
from jaxtyping import Float

from sitl.arrays import Array, Quaternion, Vec3
from sitl.compiled import compiled
from sitl.firmware.ardupilot_parameters import ArduPilotParameters
from sitl.firmware.ardupilot_pid import PidGains, reset_pid, update_pid
from sitl.firmware.ardupilot_shaping import clip, inverse_sqrt_controller, sqrt_controller
from sitl.quaternion import conjugate, from_rotation_vector, from_yaw, multiply, normalise, rotate
from sitl.vehicle import GRAVITY_M_S2

_LARGE_ERROR = math.radians(30.0)
"""Error of the thrust direction beyond which heading and feed-forward fade out."""
_MAX_HEADING_ERROR = math.radians(45.0)
_LEAN_CORRECTION = (math.radians(40.0), math.radians(720.0))
_YAW_CORRECTION = (math.radians(10.0), math.radians(120.0))
"""Least and largest angular deceleration (rad/s²) that the correction of an angle counts on."""


class AttitudeGains(NamedTuple):
    """Angle P (1/s), acceleration limits (rad/s²), time constant (s), yaw limits (rad/s, rad)."""

    p: Vec3
    acceleration: Vec3
    deceleration: Vec3
    input_time: float
    yaw_rate: float
    heading_error: float


class RateGains(NamedTuple):
    """PIDs from body rates (rad/s) to motor outputs."""

    roll: PidGains
    pitch: PidGains
    yaw: PidGains


class AttitudeState(NamedTuple):
    """Memory of both controllers, in place.

    Attributes:
        target: attitude that the vehicle should have now.
        target_rates: its rates, in its own frame (rad/s).
        rates: body rates asked of the rate controller (rad/s).
        pids: of roll, pitch and yaw rate.
    """

    target: Quaternion
    target_rates: Vec3
    rates: Vec3
    pids: Float[Array, "3 4"]


def attitude_gains(p: ArduPilotParameters) -> AttitudeGains:
    """Gains from ArduPilot parameters."""
    limits = np.radians(0.01 * np.array((p.ATC_ACCEL_R_MAX, p.ATC_ACCEL_P_MAX, p.ATC_ACCEL_Y_MAX)))
    low = np.array((_LEAN_CORRECTION[0], _LEAN_CORRECTION[0], _YAW_CORRECTION[0]))
    high = np.array((_LEAN_CORRECTION[1], _LEAN_CORRECTION[1], _YAW_CORRECTION[1]))
    deceleration = np.where(limits > 0.0, np.clip(limits / 2.0, low, high), 0.0)
    yaw_limit = float(np.clip(limits[2] / 2.0, low[2], high[2]))
    saturating = inverse_sqrt_controller(1.0 / p.ATC_RAT_YAW_P, p.ATC_ANG_YAW_P, yaw_limit)
    return AttitudeGains(
        p=np.array((p.ATC_ANG_RLL_P, p.ATC_ANG_PIT_P, p.ATC_ANG_YAW_P)),
        acceleration=limits,
        deceleration=deceleration,
        input_time=max(p.ATC_INPUT_TC, 0.01),
        yaw_rate=math.radians(0.01 * p.ATC_SLEW_YAW),
        heading_error=min(saturating, _MAX_HEADING_ERROR),
    )


def rate_gains(p: ArduPilotParameters) -> RateGains:
    """Gains from ArduPilot parameters."""
    values = p.model_dump()
    roll, pitch, yaw = (
        PidGains(
            p=values[f"ATC_RAT_{axis}_P"],
            i=values[f"ATC_RAT_{axis}_I"],
            d=values[f"ATC_RAT_{axis}_D"],
            i_max=values[f"ATC_RAT_{axis}_IMAX"],
            target_hz=values[f"ATC_RAT_{axis}_FLTT"],
            error_hz=values[f"ATC_RAT_{axis}_FLTE"],
            derivative_hz=values[f"ATC_RAT_{axis}_FLTD"],
        )
        for axis in ("RLL", "PIT", "YAW")
    )
    return RateGains(roll, pitch, yaw)


def attitude_state() -> AttitudeState:
    """Level, at rest, nothing integrated."""
    return AttitudeState(np.array((1.0, 0.0, 0.0, 0.0)), np.zeros(3), np.zeros(3), np.zeros((3, 4)))


@compiled
def retarget(state: AttitudeState, attitude: Quaternion) -> None:
    """Put the target at `attitude`."""
    for i in range(4):
        state.target[i] = attitude[i]
    normalise(state.target)


@compiled
def begin_attitude(state: AttitudeState, attitude: Quaternion, rates: Vec3) -> None:
    """Let the target be the attitude and the rates that are; nothing is integrated."""
    retarget(state, attitude)
    for axis in range(3):
        state.target_rates[axis] = rates[axis]
        state.rates[axis] = rates[axis]
        reset_pid(state.pids[axis], rates[axis], rates[axis])
        state.pids[axis, 3] = 0.0


@compiled
def lean_towards(acceleration: Vec3, heading: float) -> Quaternion:
    """The attitude whose thrust holds the weight and gives the horizontal `acceleration` (m/s²)."""
    x, y = acceleration[0] / GRAVITY_M_S2, acceleration[1] / GRAVITY_M_S2
    # From "up" to the thrust (x, y, -1): half way between the two lies the axis of the shortest turn.
    tilt = np.array((1.0 + math.sqrt(1.0 + x**2 + y**2), y, -x, 0.0))
    normalise(tilt)
    return multiply(tilt, from_yaw(heading))


@compiled
def attitude_error(attitude: Quaternion, wanted: Quaternion) -> Vec3:
    """Turn from `attitude` to `wanted`, body frame (rad): x and y align the thrust, z then the heading."""
    error = multiply(conjugate(attitude), wanted)
    if error[0] < 0.0:
        error = -error
    heading = 2.0 * math.atan2(error[3], error[0])
    tilt = multiply(error, from_yaw(-heading))
    length = math.hypot(tilt[1], tilt[2])
    scale = 2.0 * math.atan2(length, tilt[0]) / length if length > 1e-9 else 2.0
    return np.array((scale * tilt[1], scale * tilt[2], heading))


@compiled
def shape_attitude(
    gains: AttitudeGains, state: AttitudeState, wanted: Quaternion, yaw_rate: float, turns: bool, dt: float
) -> None:
    """Move the target on by `dt`, and its rates towards what brings it to `wanted`.

    `yaw_rate` (rad/s) is fed forward; where the vehicle `turns`, the heading of `wanted` does not count.
    """
    retarget(state, multiply(state.target, from_rotation_vector(state.target_rates * dt)))
    error = attitude_error(state.target, wanted)
    if turns:
        error[2] = 0.0
    for axis in range(3):
        most = gains.acceleration[axis]
        rate = sqrt_controller(error[axis], 1.0 / gains.input_time, most, dt)
        if axis == 2:
            rate = clip(rate + yaw_rate, -gains.yaw_rate, gains.yaw_rate)
        if most > 0.0:
            now = state.target_rates[axis]
            rate = clip(rate, now - most * dt, now + most * dt)
        state.target_rates[axis] = rate


@compiled
def control_attitude(
    gains: AttitudeGains, state: AttitudeState, attitude: Quaternion, rates: Vec3, dt: float
) -> None:
    """Body rates that bring the vehicle to the target: the target's own rates and a correction."""
    error = attitude_error(attitude, state.target)
    off = math.hypot(error[0], error[1])
    if abs(error[2]) > gains.heading_error:
        # A heading that the vehicle cannot keep up with waits for it.
        excess = error[2] - math.copysign(gains.heading_error, error[2])
        retarget(state, multiply(state.target, from_yaw(-excess)))
        error[2] -= excess
    turn = multiply(conjugate(attitude), state.target)
    forward = rotate(turn, (state.target_rates[0], state.target_rates[1], state.target_rates[2]))
    share = clip(2.0 - off / _LARGE_ERROR, 0.0, 1.0)
    for axis in range(3):
        correction = sqrt_controller(error[axis], gains.p[axis], gains.deceleration[axis], dt)
        if axis < 2:
            state.rates[axis] = correction + share * forward[axis]
        else:
            state.rates[axis] = share * (correction + forward[axis]) + (1.0 - share) * rates[axis]


@compiled
def control_rates(
    gains: RateGains, state: AttitudeState, rates: Vec3, lean_limited: bool, yaw_limited: bool, dt: float
) -> Vec3:
    """Roll, pitch and yaw output (−1 to 1) for the mixer."""
    out = np.empty(3)
    out[0] = update_pid(gains.roll, state.pids[0], state.rates[0], rates[0], lean_limited, dt)
    out[1] = update_pid(gains.pitch, state.pids[1], state.rates[1], rates[1], lean_limited, dt)
    out[2] = update_pid(gains.yaw, state.pids[2], state.rates[2], rates[2], yaw_limited, dt)
    return out
