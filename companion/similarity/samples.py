"""A flight as evenly sampled series, axis by axis: what was measured, and what was asked for.

The state of an axis is its position (m), velocity (m/s) and acceleration (m/s²). What accelerates a
multirotor sideways is its tilt, so north's and east's acceleration is g tan(tilt), measured before the
velocity follows; down's is the velocity's own slope.
"""

from typing import NamedTuple

import numpy as np
from jaxtyping import Float

from companion.arrays import Array, Times, Vec3s
from companion.learning.features import state_vector
from companion.recording.series import ReferenceSeries, StateSeries

GRID_S = 0.01
SLOPE_S = 0.06
"""Over which the vertical acceleration is taken."""
LONGEST_GAP_S = 0.25
_GRAVITY = 9.80665


class AxisSeries(NamedTuple):
    """One axis, a row every `GRID_S`; NaN where nothing is known.

    Attributes:
        state: position (m), velocity (m/s), acceleration (m/s²).
        reference: position (m), and velocity (m/s) and acceleration (m/s²) where most references had them.
    """

    state: Float[Array, "n 3"]
    reference: Float[Array, "n m"]


def axis_series(
    states: StateSeries, references: ReferenceSeries
) -> tuple[AxisSeries, AxisSeries, AxisSeries]:
    """North, east and down of a flight."""
    start, end = (pick(states.time_s[i], references.time_s[i]) for i, pick in ((0, max), (-1, min)))
    time_s = np.arange(start, end, GRID_S)
    position, velocity, acceleration = _measured(states, time_s)
    asked = (references.position, references.velocity, references.acceleration)
    held = [_held(time_s, references.time_s, values) for values in asked if _mostly_known(values)]
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
    slope = np.full(len(time_s), np.nan)
    steps = round(SLOPE_S / GRID_S)
    slope[steps:] = (x[steps:, 5] - x[:-steps, 5]) / SLOPE_S
    acceleration = np.column_stack((-_GRAVITY * np.tan(x[:, 7]), _GRAVITY * np.tan(x[:, 6]), slope))
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


def _mostly_known(values: Vec3s) -> bool:
    return bool(np.isfinite(values).all(axis=1).mean() > 0.5)
