"""The path that ArduPilot's GUIDED flies: a target, and the desired state that is shaped towards it.

What `mode_guided.cpp` hands to the `input_*` functions of `AC_PosControl`, in every combination of position,
velocity and acceleration. NED, SI.
"""

import math
from enum import IntEnum
from typing import NamedTuple

import numpy as np
from jaxtyping import Float, Int

from sitl.arrays import Array, Vec3
from sitl.compiled import compiled
from sitl.firmware.ardupilot_parameters import ArduPilotParameters
from sitl.firmware.ardupilot_shaping import (
    clip,
    closing_speed,
    closing_velocity_xy,
    shape_acceleration,
    shape_acceleration_xy,
    shape_velocity,
    shape_velocity_xy,
    speed_along,
)
from sitl.vehicle import GRAVITY_M_S2

_OVERSPEED_GAIN = 2.0
"""How much more acceleration and jerk a path gets, in proportion, that climbs or sinks too fast."""


class Follow(IntEnum):
    """What of the target counts, horizontally and vertically each; the kernels rely on the order."""

    POSITION = 0  # from here straight there, to a stop
    TRAJECTORY = 1  # position, velocity and acceleration
    VELOCITY = 2  # velocity and acceleration
    ACCELERATION = 3
    LEVEL = 4  # horizontally alone: nothing, for there is no position


class PathLimits(NamedTuple):
    """Speeds (m/s), accelerations (m/s²) and jerks (m/s³)."""

    speed: float
    up: float
    down: float
    acceleration: float
    vertical_acceleration: float
    jerk: float
    vertical_jerk: float


class Target(NamedTuple):
    """Where to, in place; a trajectory's target moves on by itself between two setpoints.

    Attributes:
        follow: a `Follow` for the horizontal axes and one for the vertical.
        heading: yaw (rad) and yaw rate (rad/s); NaN yaw: turn at the rate, both NaN: look along the path.
    """

    position: Vec3
    velocity: Vec3
    acceleration: Vec3
    follow: Int[np.ndarray[tuple[int, ...], np.dtype[np.int64]], "2"]
    heading: Float[Array, "2"]


class Path(NamedTuple):
    """The desired state, in place, and what held it back in the control step before.

    Attributes:
        limit: of the commanded acceleration where it was cut off, else 0; its sign alone vertically.
        position_error, velocity_error: of the controllers (m, m/s).
    """

    position: Vec3
    velocity: Vec3
    acceleration: Vec3
    limit: Vec3
    position_error: Vec3
    velocity_error: Vec3


def path_limits(p: ArduPilotParameters) -> PathLimits:
    """Limits from ArduPilot parameters; the jerks are kept below what attitude and throttle can follow."""
    acceleration, vertical = 0.01 * p.WPNAV_ACCEL, 0.01 * p.WPNAV_ACCEL_Z
    jerk, vertical_jerk = p.PSC_JERK_XY, p.PSC_JERK_Z
    snap = math.radians(0.01 * min(p.ATC_ACCEL_R_MAX, p.ATC_ACCEL_P_MAX)) * GRAVITY_M_S2
    if snap > 0.0:
        jerk = min(jerk, 0.5 * math.sqrt(acceleration * snap))
    if p.PSC_ACCZ_FLTE > 0.0:
        vertical_jerk = min(vertical_jerk, vertical * 2.0 * math.pi * p.PSC_ACCZ_FLTE / 5.0)
    return PathLimits(
        speed=0.01 * p.WPNAV_SPEED,
        up=0.01 * p.WPNAV_SPEED_UP,
        down=0.01 * p.WPNAV_SPEED_DN,
        acceleration=acceleration,
        vertical_acceleration=vertical,
        jerk=jerk,
        vertical_jerk=vertical_jerk,
    )


def target() -> Target:
    """To a stop, where that may be."""
    follow = np.full(2, int(Follow.VELOCITY), dtype=np.int64)
    return Target(np.zeros(3), np.zeros(3), np.zeros(3), follow, np.full(2, math.nan))


def path() -> Path:
    """At rest at the origin."""
    return Path(*np.zeros((6, 3)))


@compiled
def advance_target(goal: Target, dt: float) -> None:
    """Move the target on by its own velocity and acceleration."""
    for axis in range(3):
        follow = goal.follow[0 if axis < 2 else 1]
        if follow == Follow.TRAJECTORY:
            goal.position[axis] += (goal.velocity[axis] + 0.5 * goal.acceleration[axis] * dt) * dt
        if follow in (Follow.TRAJECTORY, Follow.VELOCITY):
            goal.velocity[axis] += goal.acceleration[axis] * dt


@compiled
def advance_path(now: Path, dt: float) -> None:
    """Move the desired state on by `dt`, not further in a direction in which the vehicle cannot follow."""
    dx = (now.velocity[0] + 0.5 * now.acceleration[0] * dt) * dt
    dy = (now.velocity[1] + 0.5 * now.acceleration[1] * dt) * dt
    limit, error = now.limit, now.position_error
    behind = error[0] * limit[0] + error[1] * limit[1] > 0.0
    if not (behind and dx * limit[0] + dy * limit[1] > 0.0):
        now.position[0] += dx
        now.position[1] += dy
    dx, dy = now.acceleration[0] * dt, now.acceleration[1] * dt
    error = now.velocity_error
    slow = error[0] * limit[0] + error[1] * limit[1] > 0.0
    forward = now.velocity[0] * limit[0] + now.velocity[1] * limit[1] >= 0.0
    if not (slow and forward and dx * limit[0] + dy * limit[1] > 0.0):
        now.velocity[0] += dx
        now.velocity[1] += dy

    dz = (now.velocity[2] + 0.5 * now.acceleration[2] * dt) * dt
    if not (now.position_error[2] * limit[2] > 0.0 and dz * limit[2] > 0.0):
        now.position[2] += dz
    dz = now.acceleration[2] * dt
    if now.velocity_error[2] * limit[2] > 0.0 and dz * limit[2] > 0.0:
        # Only as far as standing still.
        dz = (
            clip(dz, -abs(now.velocity[2]), abs(now.velocity[2])) if now.velocity[2] * limit[2] < 0.0 else 0.0
        )
    now.velocity[2] += dz


@compiled
def shape_path(limits: PathLimits, goal: Target, now: Path, dt: float) -> None:
    """One step of the desired state towards the target, in place."""
    advance_path(now, dt)
    fastest, up, down = limits.speed, limits.up, limits.down
    if goal.follow[0] == Follow.POSITION:
        x, y = goal.position[0] - now.position[0], goal.position[1] - now.position[1]
        z = goal.position[2] - now.position[2]
        length = math.sqrt(x**2 + y**2 + z**2)
        if length > 0.0:
            speed = speed_along(x / length, y / length, z / length, fastest, up, down)
            fastest = speed * math.hypot(x, y) / length
            up = down = speed * abs(z) / length
    _shape_horizontal(limits, goal, now, fastest, dt)
    _shape_vertical(limits, goal, now, up, down, dt)
    advance_target(goal, dt)


@compiled
def _shape_horizontal(limits: PathLimits, goal: Target, now: Path, fastest: float, dt: float) -> None:
    follow = goal.follow[0]
    most, jerk = limits.acceleration, limits.jerk
    acceleration = (now.acceleration[0], now.acceleration[1])
    forward = (goal.acceleration[0], goal.acceleration[1])
    wanted_x, wanted_y = goal.velocity[0], goal.velocity[1]
    if follow == Follow.POSITION:
        forward = (0.0, 0.0)
        wanted_x = wanted_y = 0.0
    if follow <= Follow.TRAJECTORY:
        x, y = goal.position[0] - now.position[0], goal.position[1] - now.position[1]
        closing = closing_velocity_xy(x, y, fastest, most, jerk, dt)
        wanted_x += closing[0]
        wanted_y += closing[1]
    if follow <= Follow.VELOCITY:
        velocity = (now.velocity[0], now.velocity[1])
        acceleration = shape_velocity_xy(
            (wanted_x, wanted_y), forward, velocity, acceleration, most, jerk, dt
        )
    else:
        acceleration = shape_acceleration_xy(forward, acceleration, jerk, dt)
    now.acceleration[0], now.acceleration[1] = acceleration


@compiled
def _shape_vertical(limits: PathLimits, goal: Target, now: Path, up: float, down: float, dt: float) -> None:
    follow = goal.follow[1]
    velocity = now.velocity[2]
    gain = 1.0
    if velocity > limits.down:
        gain = _OVERSPEED_GAIN * velocity / limits.down
    elif velocity < -limits.up:
        gain = -_OVERSPEED_GAIN * velocity / limits.up
    most, jerk = gain * limits.vertical_acceleration, gain * limits.vertical_jerk
    forward, wanted = goal.acceleration[2], goal.velocity[2]
    if follow == Follow.POSITION:
        forward = wanted = 0.0
    if follow <= Follow.TRAJECTORY:
        closing = closing_speed(goal.position[2] - now.position[2], most, jerk, dt)
        wanted += clip(closing, -up, down)
    if follow <= Follow.VELOCITY:
        now.acceleration[2] = shape_velocity(wanted, forward, velocity, now.acceleration[2], most, jerk, dt)
    else:
        now.acceleration[2] = shape_acceleration(forward, now.acceleration[2], jerk, dt)
