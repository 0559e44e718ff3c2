"""A point that moves to a target within speed, acceleration and jerk limits, for the AUTO modes.

A leading point keeps the limits of speed and acceleration; the path is its average over the last
acceleration / jerk seconds, which bounds the jerk, adds no overshoot and keeps a straight line straight.
"""

import math
from typing import NamedTuple

import numpy as np
from jaxtyping import Float

from sitl.arrays import Array, Vec3
from sitl.compiled import compiled

_BRAKING_SHARE = 0.9
"""Share of the acceleration planned for braking, so that whole steps do not carry it past the target."""


class Path(NamedTuple):
    """The moving point, in place: NED (m, m/s, m/s²).

    Attributes:
        history: leading points of the averaged steps, oldest first: position, velocity, acceleration.
    """

    position: Vec3
    velocity: Vec3
    acceleration: Vec3
    history: Float[Array, "n 9"]


class PathLimits(NamedTuple):
    """Speeds (m/s) and acceleration (m/s²) that the point keeps."""

    horizontal: float
    up: float
    down: float
    acceleration: float


def path_at_rest(acceleration: float, jerk: float, dt: float) -> Path:
    """At the origin; made for these limits (m/s², m/s³) and steps (s)."""
    steps = max(1, round(acceleration / jerk / dt))
    return Path(np.zeros(3), np.zeros(3), np.zeros(3), np.zeros((steps, 9)))


def braking_distance(path: Path, speed: float, acceleration: float, dt: float) -> float:
    """How far a point that begins at `speed` (m/s) goes on before it rests (m)."""
    return 0.5 * speed * (len(path.history) * dt + speed / (_BRAKING_SHARE * acceleration))


@compiled
def begin(path: Path, position: Vec3, velocity: Vec3, dt: float) -> None:
    """Let the path begin at a place with a velocity, as if it had come that way."""
    steps = path.history.shape[0]
    path.history[:, 3:9] = 0.0
    for axis in range(3):
        path.position[axis] = position[axis]
        path.velocity[axis] = velocity[axis]
        path.acceleration[axis] = 0.0
        for step in range(steps):
            ahead = (step - 0.5 * (steps - 1)) * dt
            path.history[step, axis] = position[axis] + ahead * velocity[axis]
            path.history[step, 3 + axis] = velocity[axis]


@compiled
def arrival_speed(distance: float, limit: float, limits: PathLimits, dt: float) -> float:
    """The highest speed, up to `limit`, from which the point can still stop within `distance` (m)."""
    braking = math.sqrt(2.0 * _BRAKING_SHARE * limits.acceleration * distance)
    return float(min(limit, braking, distance / dt))


@compiled
def approach(path: Path, target: Vec3, limits: PathLimits, dt: float) -> None:
    """Move the point on by `dt` (s) towards `target`, horizontally in a straight line, in place."""
    history = path.history
    last = history[-1]
    to_go = target - last[0:3]
    distance = math.hypot(to_go[0], to_go[1])
    wanted = np.zeros(3)
    if distance > 0.0:
        wanted[0:2] = to_go[0:2] * (arrival_speed(distance, limits.horizontal, limits, dt) / distance)
    vertical_limit = limits.down if to_go[2] > 0.0 else limits.up
    wanted[2] = math.copysign(arrival_speed(abs(to_go[2]), vertical_limit, limits, dt), to_go[2])

    change = wanted - last[3:6]
    largest = limits.acceleration * dt
    horizontal = math.hypot(change[0], change[1])
    if horizontal > largest:
        change[0:2] *= largest / horizontal
    change[2] = min(max(change[2], -largest), largest)

    following = np.empty(9)
    following[3:6] = last[3:6] + change
    following[0:3] = last[0:3] + dt * following[3:6]
    following[6:9] = change / dt
    history[:-1] = history[1:].copy()
    history[-1] = following
    for axis in range(3):
        path.position[axis] = history[:, axis].mean()
        path.velocity[axis] = history[:, 3 + axis].mean()
        path.acceleration[axis] = history[:, 6 + axis].mean()
