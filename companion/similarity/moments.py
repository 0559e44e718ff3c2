"""Sums of products over a flight, by block of time and band of speed: all that least squares needs of it.

A resample of the flight's blocks, a band of its envelope, or another dead time is then another sum of small
matrices, not another pass over the data.
"""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from companion.arrays import Array
from companion.similarity.samples import GRID_S, AxisSeries, drift

SAMPLE_TIME_S = 0.14
"""Time of one step of the models: about the paper's 7 Hz."""
LONGEST_DELAY_S = 0.3
BLOCK_S = 2.0
"""Longer than a vehicle remembers, so that blocks are nearly independent."""
SPEED_BANDS_M_S = (0.4, 0.8)
"""Where the envelope is divided: speeds along the axis."""

FARTHEST_M = 2.0
"""A vehicle farther from its reference is being held back by its limits, as on its way up to the start."""

_STEP = round(SAMPLE_TIME_S / GRID_S)
_LATEST = round(LONGEST_DELAY_S / GRID_S)
_STRIDE = 2


@dataclass(frozen=True, eq=False)
class Moments:
    """Σ wᵀw of rows w = (velocity, acceleration, p_r − p, v_r, a_r, 1, Δvelocity, Δacceleration).

    The references of a row are means over the step, a dead time earlier; v_r and a_r may be missing. Δ is the
    change over the step.

    Attributes:
        sums: for each dead time (every `GRID_S` from 0 on), block and band.
        inputs: how many of the columns are references, p_r − p among them.
        drift_squares: Σ of the squared speed at which the position moves beside its velocity (m²/s²).
    """

    sums: Float[Array, "delays blocks bands q q"]
    inputs: int
    drift_squares: Float[Array, " blocks"]

    @property
    def rows(self) -> float:
        """Of the whole flight."""
        return float(self._rows_of_blocks.sum())

    def drift_m_s(self, weights: Float[Array, "n blocks"]) -> Float[Array, " n"]:
        """RMS speed at which the position moves beside its velocity, with each block counted so often."""
        rms: Array = np.sqrt((weights @ self.drift_squares) / (weights @ self._rows_of_blocks))
        return rms

    @property
    def _rows_of_blocks(self) -> Float[Array, " blocks"]:
        one = 2 + self.inputs
        count: Array = self.sums[0, :, :, one, one].sum(axis=1)
        return count


def moments(series: AxisSeries) -> Moments:
    """The moments of one axis; without blocks where nothing can be used."""
    state, reference = series
    before = np.arange(_LATEST, len(state) - _STEP, _STRIDE)
    known = np.asarray(np.isfinite(state).all(axis=1))
    near = np.abs(reference[:, 0] - state[:, 0]) < FARTHEST_M
    asked = np.asarray(near & np.isfinite(reference).all(axis=1), dtype=np.float64)
    without_gap = _window_sums(asked[:, None], _LATEST + _STEP)[before - _LATEST, 0] == _LATEST + _STEP
    usable = known[before] & known[before + _STEP] & without_gap
    before = before[usable]
    blocks, group, bands = _groups(before, np.abs(state[before, 1]))
    means = _window_sums(np.nan_to_num(reference), _STEP) / _STEP
    change = state[before + _STEP, 1:] - state[before, 1:]
    own = state[before, 1:]
    sums = []
    for delay in range(_LATEST + 1):
        sent = means[before - delay]
        sent[:, 0] -= state[before, 0]
        rows = np.column_stack((own, sent, np.ones(len(before)), change))
        sums.append(_grouped(rows, group, blocks * bands))
    q = sums[0].shape[-1]
    squares = np.zeros(blocks)
    np.add.at(squares, group // bands, drift(state, before, _STEP) ** 2)
    return Moments(np.stack(sums).reshape(len(sums), blocks, bands, q, q), reference.shape[1], squares)


def _groups(
    instants: np.ndarray[tuple[int, ...], np.dtype[np.intp]], speed: Float[Array, " n"]
) -> tuple[int, np.ndarray[tuple[int, ...], np.dtype[np.intp]], int]:
    """How many blocks hold data, the group of each row (block, then band), and how many bands there are."""
    held, block = np.unique(instants // round(BLOCK_S / GRID_S), return_inverse=True)
    bands = len(SPEED_BANDS_M_S) + 1
    return len(held), block * bands + np.searchsorted(SPEED_BANDS_M_S, speed), bands


def _grouped(
    rows: Float[Array, "n q"], group: np.ndarray[tuple[int, ...], np.dtype[np.intp]], groups: int
) -> Float[Array, "groups q q"]:
    sums = np.zeros((groups, rows.shape[1], rows.shape[1]))
    order = np.argsort(group, kind="stable")
    present, first = np.unique(group[order], return_index=True)
    if len(present):
        ordered = rows[order]
        sums[present] = np.add.reduceat(ordered[:, :, None] * ordered[:, None, :], first, axis=0)
    return sums


def _window_sums(values: Float[Array, "n m"], length: int) -> Float[Array, "k m"]:
    """Sums of `length` rows from each row on."""
    total = np.vstack((np.zeros((1, values.shape[1])), np.cumsum(values, axis=0)))
    return np.asarray(total[length:] - total[:-length], dtype=np.float64)
