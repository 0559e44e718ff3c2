"""Kinematic input shaping: how ArduPilot moves a desired state towards a target within acceleration and jerk.

The square-root controller is a P controller whose output, followed as a velocity, never asks for more than a
given deceleration. Source: ArduPilot's `libraries/AP_Math/control.cpp`, as of Copter 4.7-dev of May 2025.
All are kernels; the units follow the error (m and s here). Plane vectors are tuples: no allocation.
"""

import math
from typing import TypeAlias

from sitl.compiled import compiled

Plane: TypeAlias = tuple[float, float]
"""A horizontal vector (north, east) inside a kernel."""

_CORNER_SHARE = math.sqrt(0.5)
"""Share of the acceleration that a correction keeps for directions across the motion."""


@compiled
def clip(value: float, low: float, high: float) -> float:
    """`value` inside [low, high]."""
    return min(max(value, low), high)


@compiled
def limit_length(x: float, y: float, longest: float) -> Plane:
    """A plane vector no longer than `longest`."""
    length = math.hypot(x, y)
    return (x, y) if length <= longest else (x * longest / length, y * longest / length)


@compiled
def sqrt_controller(error: float, p: float, limit: float, dt: float) -> float:
    """Rate that corrects `error`: linear (p) near zero, beyond it falling at `limit` (0: none) as error does.

    No step of `dt` (0: not looked at) overshoots.
    """
    rate = error * p
    if limit > 0.0:
        linear = limit / p**2 if p > 0.0 else 0.0
        if abs(error) > linear:
            rate = math.copysign(math.sqrt(2.0 * limit * (abs(error) - 0.5 * linear)), error)
    if dt > 0.0:
        rate = clip(rate, -abs(error) / dt, abs(error) / dt)
    return rate


@compiled
def inverse_sqrt_controller(rate: float, p: float, limit: float) -> float:
    """The error for which `sqrt_controller` gives `rate`: the distance in which that speed can be lost."""
    if limit <= 0.0:
        return rate / p if p > 0.0 else 0.0
    if p > 0.0 and abs(rate) < limit / p:
        return rate / p
    linear = limit / p**2 if p > 0.0 else 0.0
    return math.copysign(0.5 * linear + rate**2 / (2.0 * limit), rate)


@compiled
def shape_acceleration(wanted: float, acceleration: float, jerk: float, dt: float) -> float:
    """The acceleration after `dt` on its way to `wanted`."""
    return acceleration + clip(wanted - acceleration, -jerk * dt, jerk * dt)


@compiled
def shape_velocity(
    wanted: float,
    feed_forward: float,
    velocity: float,
    acceleration: float,
    most: float,
    jerk: float,
    dt: float,
) -> float:
    """The acceleration after `dt` on its way to the velocity `wanted`, itself changing by `feed_forward`.

    `most` limits the correcting acceleration, not what is fed forward.
    """
    correction = sqrt_controller(wanted - velocity, jerk / most, jerk, dt)
    return shape_acceleration(feed_forward + clip(correction, -most, most), acceleration, jerk, dt)


@compiled
def closing_speed(error: float, most: float, jerk: float, dt: float) -> float:
    """Speed at which a position error is closed so that `shape_velocity` can follow within its limits."""
    return sqrt_controller(error, 0.5 * jerk / most, 0.5 * most, dt)


@compiled
def shape_acceleration_xy(wanted: Plane, acceleration: Plane, jerk: float, dt: float) -> Plane:
    """`shape_acceleration` in the plane: the jerk is limited as a vector."""
    change = limit_length(wanted[0] - acceleration[0], wanted[1] - acceleration[1], jerk * dt)
    return acceleration[0] + change[0], acceleration[1] + change[1]


@compiled
def limit_correction(direction: Plane, x: float, y: float, most: float) -> Plane:
    """An acceleration no longer than `most` that keeps a share for the part across `direction`."""
    speed = math.hypot(direction[0], direction[1])
    if speed == 0.0:
        return limit_length(x, y, most)
    along_x, along_y = direction[0] / speed, direction[1] / speed
    along = x * along_x + y * along_y
    across_x, across_y = x - along * along_x, y - along * along_y
    if abs(along) <= math.hypot(across_x, across_y):
        return limit_length(x, y, most)
    across_x, across_y = limit_length(across_x, across_y, _CORNER_SHARE * most)
    left = math.sqrt(max(0.0, most**2 - across_x**2 - across_y**2))
    along = clip(along, -left, left)
    return across_x + along * along_x, across_y + along * along_y


@compiled
def limit_across_first(direction: Plane, x: float, y: float, most: float) -> Plane:
    """An acceleration no longer than `most` in which the part across `direction` comes first."""
    speed = math.hypot(direction[0], direction[1])
    if speed == 0.0 or math.hypot(x, y) <= most:
        return limit_length(x, y, most)
    along_x, along_y = direction[0] / speed, direction[1] / speed
    along = x * along_x + y * along_y
    across_x, across_y = limit_length(x - along * along_x, y - along * along_y, most)
    left = math.sqrt(max(0.0, most**2 - across_x**2 - across_y**2))
    along = clip(along, -left, left)
    return across_x + along * along_x, across_y + along * along_y


@compiled
def shape_velocity_xy(
    wanted: Plane,
    feed_forward: Plane,
    velocity: Plane,
    acceleration: Plane,
    most: float,
    jerk: float,
    dt: float,
) -> Plane:
    """`shape_velocity` in the plane."""
    x, y = wanted[0] - velocity[0], wanted[1] - velocity[1]
    error = math.hypot(x, y)
    gain = sqrt_controller(error, jerk / most, jerk, dt) / error if error > 0.0 else 0.0
    x, y = limit_correction(wanted, gain * x, gain * y, most)
    return shape_acceleration_xy((x + feed_forward[0], y + feed_forward[1]), acceleration, jerk, dt)


@compiled
def closing_velocity_xy(x: float, y: float, fastest: float, most: float, jerk: float, dt: float) -> Plane:
    """`closing_speed` in the plane, at most `fastest`, straight towards the target at `x`, `y` from here."""
    distance = math.hypot(x, y)
    if distance == 0.0:
        return 0.0, 0.0
    speed = min(closing_speed(distance, most, jerk, dt), fastest)
    return x * speed / distance, y * speed / distance


@compiled
def speed_along(x: float, y: float, z: float, horizontal: float, up: float, down: float) -> float:
    """The fastest that a point may move along the unit vector (x, y, z), NED, within limits by direction."""
    level = math.hypot(x, y)
    vertical = down if z > 0.0 else up
    if level == 0.0:
        return vertical
    if abs(z) * horizontal < level * vertical:
        return horizontal / level
    return vertical / abs(z) if z != 0.0 else horizontal
