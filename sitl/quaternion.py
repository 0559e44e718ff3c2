"""Unit quaternions w, x, y, z that turn body (FRD) vectors into NED; all functions are kernels."""

import math
from typing import TypeAlias

import numpy as np

from sitl.arrays import Quaternion, Vec3
from sitl.compiled import compiled

Vector: TypeAlias = tuple[float, float, float]
"""A vector inside a kernel, where an array would cost an allocation."""


@compiled
def _turn(w: float, x: float, y: float, z: float, v: Vector) -> Vector:
    tx = 2.0 * (y * v[2] - z * v[1])
    ty = 2.0 * (z * v[0] - x * v[2])
    tz = 2.0 * (x * v[1] - y * v[0])
    return (
        v[0] + w * tx + y * tz - z * ty,
        v[1] + w * ty + z * tx - x * tz,
        v[2] + w * tz + x * ty - y * tx,
    )


@compiled
def rotate(q: Quaternion, v: Vector) -> Vector:
    """A body vector in NED: R(q) v."""
    return _turn(q[0], q[1], q[2], q[3], v)


@compiled
def rotate_back(q: Quaternion, v: Vector) -> Vector:
    """A NED vector in the body frame: R(q)ᵀ v."""
    return _turn(q[0], -q[1], -q[2], -q[3], v)


@compiled
def to_world(q: Quaternion, v: Vec3) -> Vec3:
    """`rotate` for arrays."""
    return np.array(rotate(q, (v[0], v[1], v[2])))


@compiled
def conjugate(q: Quaternion) -> Quaternion:
    """The inverse rotation."""
    return np.array((q[0], -q[1], -q[2], -q[3]))


@compiled
def multiply(a: Quaternion, b: Quaternion) -> Quaternion:
    """The rotation `b` followed, in its outcome's frame, by `a`: R(a) R(b)."""
    out = np.empty(4)
    out[0] = a[0] * b[0] - a[1] * b[1] - a[2] * b[2] - a[3] * b[3]
    out[1] = a[0] * b[1] + a[1] * b[0] + a[2] * b[3] - a[3] * b[2]
    out[2] = a[0] * b[2] - a[1] * b[3] + a[2] * b[0] + a[3] * b[1]
    out[3] = a[0] * b[3] + a[1] * b[2] - a[2] * b[1] + a[3] * b[0]
    return out


@compiled
def normalise(q: Quaternion) -> None:
    """Scale `q` to unit length, in place."""
    q /= math.sqrt(q[0] ** 2 + q[1] ** 2 + q[2] ** 2 + q[3] ** 2)


@compiled
def from_rotation_vector(v: Vec3) -> Quaternion:
    """The rotation about `v` by its length (rad)."""
    angle = math.sqrt(v[0] ** 2 + v[1] ** 2 + v[2] ** 2)
    scale = 0.5 if angle < 1e-9 else math.sin(0.5 * angle) / angle
    return np.array((math.cos(0.5 * angle), scale * v[0], scale * v[1], scale * v[2]))


@compiled
def from_yaw(yaw: float) -> Quaternion:
    """Level, heading `yaw` (rad)."""
    return np.array((math.cos(0.5 * yaw), 0.0, 0.0, math.sin(0.5 * yaw)))


@compiled
def yaw_of(q: Quaternion) -> float:
    """Heading (rad, -pi to pi)."""
    return math.atan2(2.0 * (q[0] * q[3] + q[1] * q[2]), 1.0 - 2.0 * (q[2] ** 2 + q[3] ** 2))


@compiled
def from_axes(x: Vec3, y: Vec3, z: Vec3) -> Quaternion:
    """The rotation whose matrix has the columns `x`, `y`, `z` (orthonormal, right-handed)."""
    trace = x[0] + y[1] + z[2]
    # The largest of the four components is computed first, so that nothing is divided by nearly zero.
    if trace > 0.0:
        s = 2.0 * math.sqrt(1.0 + trace)
        return np.array((0.25 * s, (y[2] - z[1]) / s, (z[0] - x[2]) / s, (x[1] - y[0]) / s))
    if x[0] > y[1] and x[0] > z[2]:
        s = 2.0 * math.sqrt(1.0 + x[0] - y[1] - z[2])
        return np.array(((y[2] - z[1]) / s, 0.25 * s, (y[0] + x[1]) / s, (z[0] + x[2]) / s))
    if y[1] > z[2]:
        s = 2.0 * math.sqrt(1.0 + y[1] - x[0] - z[2])
        return np.array(((z[0] - x[2]) / s, (y[0] + x[1]) / s, 0.25 * s, (z[1] + y[2]) / s))
    s = 2.0 * math.sqrt(1.0 + z[2] - x[0] - y[1])
    return np.array(((x[1] - y[0]) / s, (z[0] + x[2]) / s, (z[1] + y[2]) / s, 0.25 * s))
