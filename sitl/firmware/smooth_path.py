"""A point that moves to a target within speed, acceleration and jerk limits, for the AUTO modes."""

import math
from typing import NamedTuple

import numpy as np

from sitl.arrays import Vec3
from sitl.compiled import compiled

_SPEED_GAIN = 5.0
_DISTANCE_GAIN = 1.5
_BRAKING_SHARE = 0.6
"""Share of acceleration and jerk planned for braking, so that the lag of the speed does not overshoot."""


class Path(NamedTuple):
    """The moving point, in place: NED (m, m/s, m/s²)."""

    position: Vec3
    velocity: Vec3
    acceleration: Vec3


class PathLimits(NamedTuple):
    """Speeds (m/s), acceleration (m/s²) and jerk (m/s³) that the point keeps."""

    horizontal: float
    up: float
    down: float
    acceleration: float
    jerk: float


def path_at_rest() -> Path:
    """At the origin."""
    return Path(np.zeros(3), np.zeros(3), np.zeros(3))


@compiled
def braking_speed(distance: float, acceleration: float, jerk: float) -> float:
    """The speed from which one can stop within `distance` (m), acceleration starting and ending at zero."""
    triangular = float((jerk * distance**2) ** (1.0 / 3.0))
    ramp = acceleration**2 / jerk
    if triangular <= ramp:
        return triangular
    return -0.5 * ramp + math.sqrt(0.25 * ramp**2 + 2.0 * acceleration * distance)


@compiled
def braking_distance(speed: float, limits: PathLimits) -> float:
    """The inverse of `braking_speed` at the limits planned for braking (m)."""
    acceleration, jerk = _BRAKING_SHARE * limits.acceleration, _BRAKING_SHARE * limits.jerk
    if speed <= acceleration**2 / jerk:
        return float(speed * math.sqrt(speed / jerk))
    return 0.5 * speed * (speed / acceleration + acceleration / jerk)


@compiled
def steer(path: Path, axis: int, wanted: float, limits: PathLimits, dt: float) -> None:
    """Move one axis on by `dt` towards the velocity `wanted`, its acceleration limited in size and jerk."""
    error = wanted - path.velocity[axis]
    linear_zone = limits.jerk / _SPEED_GAIN**2
    if abs(error) <= linear_zone:
        pull = _SPEED_GAIN * error
    else:
        pull = math.copysign(math.sqrt(2.0 * limits.jerk * (abs(error) - 0.5 * linear_zone)), error)
    before = path.acceleration[axis]
    change = min(max(pull - before, -limits.jerk * dt), limits.jerk * dt)
    after = min(max(before + change, -limits.acceleration), limits.acceleration)
    path.acceleration[axis] = after
    path.velocity[axis] += after * dt
    path.position[axis] += path.velocity[axis] * dt


@compiled
def approach(path: Path, target: Vec3, limits: PathLimits, dt: float) -> None:
    """Move the point on by `dt` (s) towards `target`, horizontally in a straight line, in place."""
    acceleration, jerk = _BRAKING_SHARE * limits.acceleration, _BRAKING_SHARE * limits.jerk
    north, east = target[0] - path.position[0], target[1] - path.position[1]
    distance = math.hypot(north, east)
    per_metre = 0.0
    if distance > 0.0:
        speed = min(limits.horizontal, _DISTANCE_GAIN * distance, braking_speed(distance, acceleration, jerk))
        per_metre = speed / distance
    down = target[2] - path.position[2]
    vertical = min(
        limits.down if down > 0.0 else limits.up,
        _DISTANCE_GAIN * abs(down),
        braking_speed(abs(down), acceleration, jerk),
    )
    steer(path, 0, per_metre * north, limits, dt)
    steer(path, 1, per_metre * east, limits, dt)
    steer(path, 2, math.copysign(vertical, down), limits, dt)
