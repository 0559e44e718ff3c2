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
    north, east, down = target[0] - last[0], target[1] - last[1], target[2] - last[2]
    distance = math.hypot(north, east)
    per_metre = 0.0
    if distance > 0.0:
        per_metre = arrival_speed(distance, limits.horizontal, limits, dt) / distance
    vertical = arrival_speed(abs(down), limits.down if down > 0.0 else limits.up, limits, dt)

    change = np.array(
        (per_metre * north - last[3], per_metre * east - last[4], math.copysign(vertical, down) - last[5])
    )
    largest = limits.acceleration * dt
    horizontal = math.hypot(change[0], change[1])
    if horizontal > largest:
        change[0] *= largest / horizontal
        change[1] *= largest / horizontal
    change[2] = min(max(change[2], -largest), largest)

    steps = history.shape[0]
    for step in range(steps - 1):
        for column in range(9):
            history[step, column] = history[step + 1, column]
    for axis in range(3):
        last[3 + axis] += change[axis]
        last[axis] += dt * last[3 + axis]
        last[6 + axis] = change[axis] / dt
        path.position[axis] = history[:, axis].sum() / steps
        path.velocity[axis] = history[:, 3 + axis].sum() / steps
        path.acceleration[axis] = history[:, 6 + axis].sum() / steps
