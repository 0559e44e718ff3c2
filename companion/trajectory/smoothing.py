"""Taking the tremor out of a drawn line while staying close to it."""

import numpy as np
from jaxtyping import Float
from scipy.linalg import solveh_banded
from scipy.ndimage import uniform_filter1d

from companion.arrays import Array

_DIFFERENCES = np.array([-1.0, 3.0, -3.0, 1.0])
_STRENGTHS = 10.0 ** np.arange(-2.0, 12.1, 0.25)
_NEIGHBOURHOOD = 0.01
"""Share of the line over which deviations are averaged: tremor averages out, a cut corner does not."""
_SPACING = 0.0025
"""Distance between points of an evenly spaced line, as a share of the line's size."""
_FEWEST, _MOST = 1000, 8000


def lengths(points: Float[Array, "n d"]) -> Float[Array, " n"]:
    """The length of the line up to each point."""
    return np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1))])


def evenly_spaced(points: Float[Array, "n d"], parameter: Float[Array, " n"]) -> Float[Array, "m d"]:
    """The line through `points`, straight between them, at evenly spaced values of their rising `parameter`.

    So many that they are 0.25 % of the line's size apart, within reason.
    """
    spacing = _SPACING * np.ptp(points, axis=0).max()
    count = int(np.clip(max(len(points), lengths(points)[-1] / spacing), _FEWEST, _MOST))
    even = np.linspace(parameter[0], parameter[-1], count)
    return np.stack([np.interp(even, parameter, axis) for axis in points.T], axis=1)


def smooth(points: Float[Array, "n d"], tolerance: float) -> Float[Array, "n d"]:
    """The smoothest line that stays within `tolerance` of the given one, as evenly spaced as that.

    Smoothest: least third differences, the discrete form of the minimum-jerk criterion (Flash and Hogan,
    J. Neuroscience 5, 1985), by penalised least squares (Whittaker 1923; Eilers, Anal. Chem. 75, 2003).
    Within: by the mean deviation of each hundredth of the line. `tolerance` is in the unit of `points`.
    """
    neighbours = max(1, round(_NEIGHBOURHOOD * len(points)))
    smoothest = points
    for strength in _STRENGTHS:
        smoothed = _penalised(points, strength)
        deviation = uniform_filter1d(smoothed - points, neighbours, axis=0)
        if np.linalg.norm(deviation, axis=1).max() > tolerance:
            break
        smoothest = smoothed
    return smoothest


def _penalised(points: Float[Array, "n d"], strength: float) -> Float[Array, "n d"]:
    """What minimises |z − points|² + strength |third differences of z|²."""
    n = len(points)
    banded = np.zeros((4, n))
    for diagonal in range(4):
        products = _DIFFERENCES[: 4 - diagonal] * _DIFFERENCES[diagonal:]
        banded[diagonal, : n - diagonal] = strength * np.convolve(np.ones(n - 3), products)
    banded[0] += 1.0
    return np.asarray(solveh_banded(banded, points, lower=True))
