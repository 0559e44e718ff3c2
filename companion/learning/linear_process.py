"""A Gaussian process with a linear kernel, that finds the noise of its observations by itself.

y = h(ξ)ᵀβ + noise, with β ~ N(0, diag(p²)): Bayesian linear regression (Rasmussen & Williams, Gaussian
Processes for Machine Learning, 2006, section 2.1). The noise's deviation is the one under which the
observations are likeliest, so that exact observations are fitted to rounding and noisy ones are smoothed.
"""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from companion.arrays import Array

NOISE_LEVELS = np.geomspace(1e-16, 1.0, 33)
"""Deviations of the noise that are tried, as shares of the largest observation: rounding up to all of it."""

SMALLEST_OBSERVATION = 1e-100
"""Stands in for the largest observation where all are zero: its square is a number still."""


@dataclass(frozen=True, eq=False)
class LinearPosterior:
    """What the observations tell of β.

    Attributes:
        mean: shape (m,).
        covariance: shape (m, m).
        noise: standard deviation of the noise, in the unit of the outputs.
    """

    mean: Float[Array, " m"]
    covariance: Float[Array, "m m"]
    noise: float


def fit_linear(
    basis: Float[Array, "n m"], outputs: Float[Array, " n"], prior: Float[Array, " m"]
) -> LinearPosterior:
    """The posterior of β under the likeliest noise.

    Everything follows from the singular values of the basis: nothing is squared before it is added to the
    noise, so that nearly collinear observations keep their digits.

    Args:
        basis: h(ξ), a row for each observation.
        outputs: y.
        prior: standard deviations p of β before the first observation.
    """
    left, singular, right = np.linalg.svd(basis * prior, full_matrices=False)
    along = left.T @ outputs
    across = outputs - left @ along

    levels = NOISE_LEVELS * max(float(np.max(np.abs(outputs))), SMALLEST_OBSERVATION)
    variances = levels[:, None] ** 2
    explained = singular**2 + variances
    misfit = np.sum(along**2 / explained, axis=1) + across @ across / variances[:, 0]
    spread = np.sum(np.log(explained), axis=1) + (len(outputs) - len(singular)) * np.log(variances[:, 0])
    best = int(np.argmin(misfit + spread))

    directions = prior[:, None] * right.T
    unseen = np.diag(prior**2) - directions @ directions.T
    left_open = variances[best] / explained[best]
    return LinearPosterior(
        mean=directions @ (singular / explained[best] * along),
        covariance=directions * left_open @ directions.T + unseen,
        noise=float(levels[best]),
    )
