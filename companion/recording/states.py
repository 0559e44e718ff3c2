"""States out of what a log holds apart: positions, attitudes and rates, each with times of its own."""

from typing import TypeAlias

import numpy as np
from jaxtyping import Float
from scipy.spatial.transform import Rotation

from companion.arrays import Array, Times, Vec3s
from companion.errors import InputError
from companion.recording.clock_map import rising
from companion.recording.series import StateSeries

Sampled: TypeAlias = tuple[Times, Float[Array, "n d"]]
"""Vectors, and when each held (s)."""

FARTHEST_ATTITUDE_S = 0.1
"""A position without an attitude that near is no state, here as in flight."""


def joined_states(motion: Sampled, attitude: Sampled, rates: Sampled) -> StateSeries:
    """A state for each position, with the attitude and the rates as they were between their neighbours.

    Left out is what is not finite, what is not later than all before, and positions with no attitude near.

    Args:
        motion: position and velocity (6,): NED, m and m/s.
        attitude: roll, pitch, yaw (rad).
        rates: about the body's axes (rad/s).

    Raises:
        InputError: no position is left.
    """
    (time_s, moved), (attitude_s, angles), (rates_s, turning) = map(_clean, (motion, attitude, rates))
    near = _distance(time_s, attitude_s) <= FARTHEST_ATTITUDE_S
    if not near.any() or not len(rates_s):
        raise InputError(
            f"no local position with an attitude within {FARTHEST_ATTITUDE_S} s: record both at 20 Hz or more"
        )
    time_s, moved = time_s[near], moved[near]
    turned = _interpolated(time_s, attitude_s, np.unwrap(angles, axis=0))
    return StateSeries(
        time_s=time_s,
        position=moved[:, 0:3],
        velocity=moved[:, 3:6],
        attitude=(turned + np.pi) % (2.0 * np.pi) - np.pi,
        rates=_interpolated(time_s, rates_s, turning),
    )


def roll_pitch_yaw(quaternion: Float[Array, "n 4"]) -> Vec3s:
    """Attitude (rad) of rotations from body to NED, scalar first; NaN where there is none."""
    turned = np.full((len(quaternion), 3), np.nan)
    known = np.isfinite(quaternion).all(axis=1) & quaternion.any(axis=1)
    rotation = Rotation.from_quat(quaternion[known], scalar_first=True)
    turned[known] = rotation.as_euler("ZYX", suppress_warnings=True)[:, ::-1]
    return turned


def body_rates(time_s: Times, quaternion: Float[Array, "n 4"]) -> Vec3s:
    """Rates about the body's axes (rad/s) out of its attitude, for logs without a gyroscope's.

    NaN where there is no attitude or none after it; `quaternion` is from body to NED, scalar first.
    """
    rates = np.full((len(quaternion), 3), np.nan)
    known = np.flatnonzero(np.isfinite(quaternion).all(axis=1) & quaternion.any(axis=1))
    rotation = Rotation.from_quat(quaternion[known], scalar_first=True)
    turned = (rotation[:-1].inv() * rotation[1:]).as_rotvec()
    rates[known[:-1]] = turned / np.diff(time_s[known])[:, None]
    return rates


def _clean(sampled: Sampled) -> Sampled:
    time_s, values = sampled
    finite = np.isfinite(values).all(axis=1)
    time_s, values = time_s[finite], values[finite]
    usable = rising(time_s)
    return time_s[usable], values[usable]


def _distance(time_s: Times, known_s: Times) -> Times:
    """How far the nearest of the rising `known_s` is from each instant (s); infinite without any."""
    padded = np.concatenate(([-np.inf], known_s, [np.inf]))
    after = np.searchsorted(padded, time_s)
    return np.minimum(padded[after] - time_s, time_s - padded[after - 1])


def _interpolated(time_s: Times, known_s: Times, values: Float[Array, "m d"]) -> Float[Array, "n d"]:
    return np.column_stack([np.interp(time_s, known_s, axis) for axis in values.T])
