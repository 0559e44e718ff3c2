"""PX4's multicopter position controller: setpoint to thrust vector and attitude, 100 Hz.

Position P, velocity PID with feed-forward, acceleration to thrust with hover-thrust scaling, vertical
priority and anti-windup; the order of the steps is that of PX4's module `mc_pos_control`
(https://docs.px4.io/main/en/flight_stack/controller_diagrams.html).
"""

import math
from typing import NamedTuple

import numpy as np
from jaxtyping import Float

from sitl.arrays import Array, Quaternion, Vec3
from sitl.compiled import compiled
from sitl.firmware.px4_filters import blend
from sitl.firmware.px4_parameters import Px4Parameters
from sitl.quaternion import from_axes, yaw_of
from sitl.vehicle import GRAVITY_M_S2

_MIN_THRUST = 1e-3
"""A thrust vector is never shorter, so that it has a direction to fly by."""

Vec2 = Float[Array, "2"]


class PositionGains(NamedTuple):
    """Gains and limits in SI units; thrusts as a fraction of the maximum.

    Attributes:
        decoupled: the tilt for a horizontal acceleration does not depend on the vertical one.
    """

    position_p: Vec3
    velocity_p: Vec3
    velocity_i: Vec3
    velocity_d: Vec3
    velocity_cutoff_hz: float
    derivative_cutoff_hz: float
    max_speed: float
    max_down: float
    max_thrust: float
    horizontal_margin: float
    decoupled: bool


class PositionLimits(NamedTuple):
    """What follows the flight.

    Attributes:
        max_up: m/s; negative while a takeoff ramps up from no thrust.
        max_tilt: rad.
        min_thrust, hover_thrust: fraction of the maximum.
    """

    max_up: float
    max_tilt: float
    min_thrust: float
    hover_thrust: float


class PositionState(NamedTuple):
    """Memory of the controller, in place.

    Attributes:
        integral: of the velocity controller (m/s²).
        velocity: as estimated, low-passed (m/s).
        acceleration: its derivative, low-passed (m/s²).
        wanted: acceleration setpoint of the last step (m/s²).
    """

    integral: Vec3
    velocity: Vec3
    acceleration: Vec3
    wanted: Vec3


class PositionSetpoint(NamedTuple):
    """As `interface.Setpoint`, for the kernel; `heading` is yaw (rad) and yaw rate (rad/s)."""

    position: Vec3
    velocity: Vec3
    acceleration: Vec3
    heading: Vec2


class AttitudeSetpoint(NamedTuple):
    """What the position controller asks of the attitude controller, in place.

    Attributes:
        attitude: unit quaternion.
        thrust_and_yaw_rate: collective thrust (0 to 1), yaw rate about the world's down axis (rad/s).
    """

    attitude: Quaternion
    thrust_and_yaw_rate: Vec2


def position_gains(p: Px4Parameters) -> PositionGains:
    """Gains from PX4 parameters."""
    return PositionGains(
        position_p=np.array((p.MPC_XY_P, p.MPC_XY_P, p.MPC_Z_P)),
        velocity_p=np.array((p.MPC_XY_VEL_P_ACC, p.MPC_XY_VEL_P_ACC, p.MPC_Z_VEL_P_ACC)),
        velocity_i=np.array((p.MPC_XY_VEL_I_ACC, p.MPC_XY_VEL_I_ACC, p.MPC_Z_VEL_I_ACC)),
        velocity_d=np.array((p.MPC_XY_VEL_D_ACC, p.MPC_XY_VEL_D_ACC, p.MPC_Z_VEL_D_ACC)),
        velocity_cutoff_hz=p.MPC_VEL_LP,
        derivative_cutoff_hz=p.MPC_VELD_LP,
        max_speed=p.MPC_XY_VEL_MAX,
        max_down=p.MPC_Z_VEL_MAX_DN,
        max_thrust=p.MPC_THR_MAX,
        horizontal_margin=p.MPC_THR_XY_MARG,
        decoupled=bool(p.MPC_ACC_DECOUPLE),
    )


def position_state() -> PositionState:
    """At rest, nothing integrated."""
    return PositionState(*np.zeros((4, 3)))


def position_setpoint() -> PositionSetpoint:
    """Every channel off."""
    return PositionSetpoint(
        np.full(3, math.nan), np.full(3, math.nan), np.full(3, math.nan), np.full(2, math.nan)
    )


def attitude_setpoint() -> AttitudeSetpoint:
    """Level, no thrust."""
    return AttitudeSetpoint(np.array((1.0, 0.0, 0.0, 0.0)), np.zeros(2))


@compiled
def is_flyable(setpoint: PositionSetpoint) -> bool:
    """Whether each axis has some setpoint, and north and east come in pairs."""
    for axis in range(3):
        if (
            math.isnan(setpoint.position[axis])
            and math.isnan(setpoint.velocity[axis])
            and math.isnan(setpoint.acceleration[axis])
        ):
            return False
    return (
        math.isnan(setpoint.position[0]) == math.isnan(setpoint.position[1])
        and math.isnan(setpoint.velocity[0]) == math.isnan(setpoint.velocity[1])
        and math.isnan(setpoint.acceleration[0]) == math.isnan(setpoint.acceleration[1])
    )


@compiled
def filter_velocity(gains: PositionGains, state: PositionState, velocity: Vec3, dt: float) -> None:
    """Low-pass the estimated velocity (MPC_VEL_LP) and the derivative of that (MPC_VELD_LP)."""
    fresh, fresh_derivative = blend(gains.velocity_cutoff_hz, dt), blend(gains.derivative_cutoff_hz, dt)
    for axis in range(3):
        change = fresh * (velocity[axis] - state.velocity[axis])
        state.velocity[axis] += change
        state.acceleration[axis] += fresh_derivative * (change / dt - state.acceleration[axis])


@compiled
def prioritise(first: Vec2, second: Vec2, limit: float) -> Vec2:
    """The sum of two horizontal vectors, with as much of the second as the limit on its length leaves."""
    both: Vec2 = first + second
    if math.hypot(both[0], both[1]) <= limit:
        return both
    length = math.hypot(first[0], first[1])
    if length >= limit:
        return first * (limit / length)
    # |first + s second| = limit has one positive root, since the first lies inside the limit.
    a = second[0] ** 2 + second[1] ** 2
    b = first[0] * second[0] + first[1] * second[1]
    c = length**2 - limit**2
    s: float = (-b + math.sqrt(b * b - a * c)) / a
    return first + s * second


@compiled
def velocity_setpoint(
    gains: PositionGains, limits: PositionLimits, setpoint: PositionSetpoint, position: Vec3
) -> Vec3:
    """Velocity feed-forward plus P on the position error, limited; NaN where the axis has neither."""
    correction = gains.position_p * (setpoint.position - position)
    feed_forward = setpoint.velocity.copy()
    off = np.isnan(correction) & np.isnan(feed_forward)
    for axis in range(3):
        if math.isnan(correction[axis]):
            correction[axis] = 0.0
        if math.isnan(feed_forward[axis]):
            feed_forward[axis] = 0.0
    out = np.empty(3)
    horizontal = prioritise(correction[0:2], feed_forward[0:2], gains.max_speed)
    out[0], out[1] = horizontal[0], horizontal[1]
    out[2] = max(-limits.max_up, min(correction[2] + feed_forward[2], gains.max_down))
    for axis in range(3):
        if off[axis]:
            out[axis] = math.nan
    return out


@compiled
def thrust_vector(gains: PositionGains, limits: PositionLimits, acceleration: Vec3) -> Vec3:
    """Thrust (NED, fraction of the maximum) for an acceleration setpoint, with limited tilt."""
    g = GRAVITY_M_S2
    up = -acceleration[2] + g
    horizontal = math.hypot(acceleration[0], acceleration[1])
    tilt = min(math.atan2(horizontal, g if gains.decoupled else up), limits.max_tilt)
    collective = max(up * limits.hover_thrust / g / math.cos(tilt), limits.min_thrust, _MIN_THRUST)
    out = np.empty(3)
    scale = collective * math.sin(tilt) / horizontal if horizontal > 0.0 else 0.0
    out[0] = scale * acceleration[0]
    out[1] = scale * acceleration[1]
    out[2] = -collective * math.cos(tilt)
    return out


@compiled
def limit_thrust(gains: PositionGains, thrust: Vec3) -> None:
    """Keep the thrust below its maximum in place: vertical first, but for a horizontal margin."""
    horizontal = math.hypot(thrust[0], thrust[1])
    margin = min(horizontal, gains.horizontal_margin)
    thrust[2] = max(thrust[2], -math.sqrt(gains.max_thrust**2 - margin**2))
    left = math.sqrt(max(0.0, gains.max_thrust**2 - thrust[2] ** 2))
    if horizontal > left:
        thrust[0] *= left / horizontal
        thrust[1] *= left / horizontal


@compiled
def integrate(
    gains: PositionGains,
    limits: PositionLimits,
    state: PositionState,
    error: Vec3,
    wanted: Vec3,
    thrust: Vec3,
    dt: float,
) -> None:
    """Velocity integral with anti-windup: clamped vertically, tracking horizontally (Rundqwist 1990).

    `error` is the velocity error, `wanted` the acceleration setpoint, `thrust` the one before limits in
    the vertical and after them in the horizontal axes.
    """
    error = error.copy()
    if (thrust[2] >= -limits.min_thrust and error[2] >= 0.0) or (
        thrust[2] <= -gains.max_thrust and error[2] <= 0.0
    ):
        error[2] = 0.0
    produced = thrust * (GRAVITY_M_S2 / limits.hover_thrust)
    if wanted[0] ** 2 + wanted[1] ** 2 > produced[0] ** 2 + produced[1] ** 2:
        for axis in range(2):
            error[axis] -= 2.0 / gains.velocity_p[0] * (wanted[axis] - produced[axis])
    for axis in range(3):
        if not math.isnan(error[axis]):
            state.integral[axis] += gains.velocity_i[axis] * error[axis] * dt
    state.integral[2] = min(max(state.integral[2], -GRAVITY_M_S2), GRAVITY_M_S2)


@compiled
def forget_unused_integral(state: PositionState, setpoint: PositionSetpoint) -> None:
    """Drop the horizontal integral while neither position nor velocity is controlled in both axes."""
    by_position = not (math.isnan(setpoint.position[0]) or math.isnan(setpoint.position[1]))
    by_velocity = not (math.isnan(setpoint.velocity[0]) or math.isnan(setpoint.velocity[1]))
    if not (by_position or by_velocity):
        state.integral[0] = 0.0
        state.integral[1] = 0.0


def change_hover_thrust(state: PositionState, before: float, after: float) -> None:
    """Let the integral take over what another hover thrust changes: the thrust goes on without a step."""
    state.integral[2] += (state.wanted[2] - GRAVITY_M_S2) * (before / after - 1.0)


@compiled
def point_thrust(thrust: Vec3, yaw: float, out: AttitudeSetpoint) -> None:
    """Attitude whose down axis opposes `thrust` with the nose towards `yaw`, and its collective."""
    length = math.sqrt(thrust[0] ** 2 + thrust[1] ** 2 + thrust[2] ** 2)
    z = -thrust / length
    # x is normal to z and to the right-hand side of the heading; z points down as the tilt is below 90°.
    right = np.array((-math.sin(yaw), math.cos(yaw), 0.0))
    x = np.array((right[1] * z[2], -right[0] * z[2], right[0] * z[1] - right[1] * z[0]))
    x /= math.sqrt(x[0] ** 2 + x[1] ** 2 + x[2] ** 2)
    y = np.array((z[1] * x[2] - z[2] * x[1], z[2] * x[0] - z[0] * x[2], z[0] * x[1] - z[1] * x[0]))
    attitude = from_axes(x, y, z)
    for i in range(4):
        out.attitude[i] = attitude[i]
    out.thrust_and_yaw_rate[0] = length


@compiled
def control_position(
    gains: PositionGains,
    limits: PositionLimits,
    state: PositionState,
    setpoint: PositionSetpoint,
    position: Vec3,
    velocity: Vec3,
    attitude: Quaternion,
    dt: float,
    out: AttitudeSetpoint,
) -> None:
    """One step of the position controller: `setpoint` and estimate to `out`.

    NaN switches an axis of a channel off. A setpoint that cannot be flown (an axis without any, or north
    without east) is answered by stopping: zero velocity, the present heading.
    """
    filter_velocity(gains, state, velocity, dt)
    forget_unused_integral(state, setpoint)
    flyable = is_flyable(setpoint)
    wanted_velocity = velocity_setpoint(gains, limits, setpoint, position) if flyable else np.zeros(3)
    error = wanted_velocity - state.velocity
    wanted = gains.velocity_p * error + state.integral - gains.velocity_d * state.acceleration
    for axis in range(3):
        feed_forward = setpoint.acceleration[axis]
        if math.isnan(wanted[axis]):
            wanted[axis] = feed_forward
        elif flyable and not math.isnan(feed_forward):
            wanted[axis] += feed_forward
        state.wanted[axis] = wanted[axis]
    thrust = thrust_vector(gains, limits, wanted)
    unlimited_vertical = thrust[2]
    limit_thrust(gains, thrust)
    produced = np.array((thrust[0], thrust[1], unlimited_vertical))
    integrate(gains, limits, state, error, wanted, produced, dt)

    yaw, yaw_rate = setpoint.heading[0], setpoint.heading[1]
    point_thrust(thrust, yaw if flyable and not math.isnan(yaw) else yaw_of(attitude), out)
    out.thrust_and_yaw_rate[1] = yaw_rate if flyable and not math.isnan(yaw_rate) else 0.0
