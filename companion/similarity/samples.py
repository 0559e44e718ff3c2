"""A flight as evenly sampled series, axis by axis: what was measured, and what was asked for.

The state of an axis is its position (m), velocity (m/s) and acceleration (m/s²). What accelerates a
multirotor sideways is its tilt, so north's and east's acceleration is g tan(tilt), measured before the
velocity follows. What accelerates it down, the thrust, is in no record: there it is 0 throughout. (The slope
of the velocity tells nothing new; on a vehicle that tracks well, it hides what the reference does.)
"""

from typing import NamedTuple

import numpy as np
from jaxtyping import Float

from companion.arrays import Array, Times, Vec3s
from companion.errors import InputError
from companion.learning.features import state_vector
from companion.recording.series import Indices, ReferenceSeries, StateSeries

GRID_S = 0.01
LONGEST_GAP_S = 0.25
_GRAVITY = 9.80665


class AxisSeries(NamedTuple):
    """One axis, a row every `GRID_S`; NaN where nothing is known.

    Attributes:
        state: position (m), velocity (m/s), acceleration (m/s²).
        reference: position (m), and velocity (m/s) and acceleration (m/s²) where those were sent as well; a
            velocity of 0 where acceleration was sent without one.
    """

    state: Float[Array, "n 3"]
    reference: Float[Array, "n m"]


def axis_series(
    states: StateSeries, references: ReferenceSeries
) -> tuple[AxisSeries, AxisSeries, AxisSeries]:
    """North, east and down of a flight.

    Of references of several kinds (position alone, with velocity, with acceleration, to which a vehicle
    answers in different ways), those count that moved most in sum; others are as if nothing were known.

    Raises:
        InputError: no position was sent.
    """
    start, end = (pick(states.time_s[i], references.time_s[i]) for i, pick in ((0, max), (-1, min)))
    time_s = np.arange(start, end, GRID_S)
    position, velocity, acceleration = _measured(states, time_s)
    held = [_held(time_s, references.time_s, values) for values in _of_one_kind(references)]
    north, east, down = (
        AxisSeries(
            np.column_stack((position[:, axis], velocity[:, axis], acceleration[:, axis])),
            np.column_stack([values[:, axis] for values in held]),
        )
        for axis in range(3)
    )
    return north, east, down


def _measured(states: StateSeries, time_s: Times) -> tuple[Vec3s, Vec3s, Vec3s]:
    x = state_vector(states.position, states.velocity, states.attitude, states.rates)
    x = np.column_stack([np.interp(time_s, states.time_s, column) for column in x.T])
    x[_in_gap(time_s, states.time_s)] = np.nan
    unknown = np.zeros(len(time_s))
    acceleration = np.column_stack((-_GRAVITY * np.tan(x[:, 7]), _GRAVITY * np.tan(x[:, 6]), unknown))
    return x[:, 0:3], x[:, 3:6], acceleration


def _held(time_s: Times, sent_s: Times, values: Vec3s) -> Vec3s:
    """Each reference until the next one; NaN where none came for long."""
    newest = np.searchsorted(sent_s, time_s, side="right") - 1
    held = values[newest]
    held[time_s - sent_s[newest] > LONGEST_GAP_S] = np.nan
    return held


def _in_gap(time_s: Times, known_s: Times) -> np.ndarray[tuple[int, ...], np.dtype[np.bool_]]:
    after = np.clip(np.searchsorted(known_s, time_s), 1, len(known_s) - 1)
    gap: np.ndarray[tuple[int, ...], np.dtype[np.bool_]] = known_s[after] - known_s[after - 1] > LONGEST_GAP_S
    return gap


def _of_one_kind(references: ReferenceSeries) -> list[Vec3s]:
    """The position, and velocity and acceleration where they belong to the kind that moved most."""
    parts = (references.position, references.velocity, references.acceleration)
    known = np.column_stack([np.isfinite(part).all(axis=1) for part in parts])
    moved = np.linalg.norm(np.diff(references.position, axis=0, prepend=references.position[:1]), axis=1)
    kinds, kind = np.unique(known, axis=0, return_inverse=True)
    if not kinds[:, 0].any():
        raise InputError("no position references in this flight: send positions, with velocities or without")
    total = np.bincount(kind.ravel(), np.nan_to_num(moved), minlength=len(kinds))
    most = int(np.argmax(np.where(kinds[:, 0], total, -1.0)))
    chosen = (kind.ravel() == most)[:, None]
    if not kinds[most, 1]:
        parts = (references.position, np.zeros_like(references.velocity), references.acceleration)
    last = int(np.flatnonzero(kinds[most])[-1])
    return [np.where(chosen, part, np.nan) for part in parts[: last + 1]]


def drift(state: Float[Array, "n 3"], rows: Indices, steps: int) -> Float[Array, " k"]:
    """Speed (m/s) at which the position moves beside its own velocity, over `steps` from these rows on.

    An estimator that is being pulled to its measurements does that.
    """
    position, velocity = state[:, 0], state[:, 1]
    between = velocity[rows[:, None] + np.arange(steps + 1)]
    integral = GRID_S * (between.sum(axis=1) - (between[:, 0] + between[:, -1]) / 2.0)
    beside: Array = (position[rows + steps] - position[rows] - integral) / (steps * GRID_S)
    return beside
