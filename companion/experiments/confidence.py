"""Confidence intervals of least-squares estimates whose residuals are correlated in time."""

from collections.abc import Sequence

import numpy as np
from jaxtyping import Float

from companion.arrays import Array

_NORMAL_95 = 1.96
_BLIND = 1e-9
"""Eigenvalues of the normal matrix below this share of the greatest are zero."""
_TOUCHED = 1e-3


def confidence_half_widths(
    jacobian: Float[Array, "n channels k"], residuals: Float[Array, "n channels"], lengths: Sequence[int]
) -> Float[Array, " k"]:
    """Half widths of the 95 % confidence intervals at the minimum.

    The covariance is A⁻¹ (Σ σ_c² τ_c J_cᵀJ_c) A⁻¹ with A = Σ J_cᵀJ_c. Of each channel c, σ_c² is the mean
    square and τ_c the integrated autocorrelation of the residuals: n samples are worth n / τ_c.

    Args:
        jacobian: of the residuals.
        residuals: at the minimum, in the order of time within each stretch.
        lengths: samples of each stretch; they add up to n.

    Returns:
        In the units of the parameters; infinite for those on which the residuals do not depend, alone or
        together with others.
    """
    grams = np.einsum("nci,ncj->cij", jacobian, jacobian)
    variances = (residuals**2).mean(axis=0) * _correlated_samples(residuals, lengths)
    values, vectors = np.linalg.eigh(grams.sum(axis=0))
    blind = values <= _BLIND * values[-1]
    seen = vectors[:, ~blind]
    inverse = seen / values[~blind] @ seen.T
    covariance = inverse @ np.einsum("c,cij->ij", variances, grams) @ inverse
    half_widths: Float[Array, " k"] = _NORMAL_95 * np.sqrt(np.maximum(np.diag(covariance), 0.0))
    half_widths[(np.abs(vectors[:, blind]) > _TOUCHED).any(axis=1)] = np.inf
    return half_widths


def _correlated_samples(
    residuals: Float[Array, "n channels"], lengths: Sequence[int]
) -> Float[Array, " channels"]:
    """How many samples of a channel are worth one: 1 + 2 Σ ρ_k, up to the first ρ_k that is not positive."""
    covariances = np.zeros((max(lengths), residuals.shape[1]))
    for stretch in np.split(residuals, np.cumsum(lengths)[:-1]):
        spectrum = np.abs(np.fft.rfft(stretch, 2 * len(stretch), axis=0)) ** 2
        covariances[: len(stretch)] += np.fft.irfft(spectrum, 2 * len(stretch), axis=0)[: len(stretch)]
    correlations = covariances / np.maximum(covariances[0], np.finfo(float).tiny)
    until_zero = np.logical_and.accumulate(correlations > 0.0, axis=0)
    samples: Float[Array, " channels"] = np.maximum(2.0 * (correlations * until_zero).sum(axis=0) - 1.0, 1.0)
    return samples
