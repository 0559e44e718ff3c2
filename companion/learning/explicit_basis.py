"""Gaussian-process regression with explicit basis functions, on windows that are nearly collinear.

The model is g(ξ) = h(ξ)ᵀβ + f(ξ): a polynomial whose coefficients have a vague prior, plus a Gaussian process
f with a squared-exponential kernel and identical length scales (Rasmussen & Williams, Gaussian Processes for
Machine Learning, 2006, section 2.7, equation 2.42; the paper, section VI-A).

In closed loop the newest observations lie almost on a line, so H Kᵧ⁻¹ Hᵀ, which the textbook inverts, has a
condition number beyond 10²⁰. Here the data are whitened by the Cholesky factor of Kᵧ and β is a least-squares
solution by singular values: nothing is squared, and what the window does not determine stays zero.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from companion.arrays import Array

CUTOFF = 1e-14
"""Singular values below this share of the largest count as undetermined: rounding of the data, no more."""


@dataclass(frozen=True)
class Hyperparameters:
    """What is chosen by maximum likelihood; σ1² follows in closed form.

    Attributes:
        length_scale: l, in the unit of the inputs.
        noise_ratio: σ2² / σ1², noise variance over prior variance.
    """

    length_scale: float = 1.0
    noise_ratio: float = 1e-2

    def neighbourhood(self) -> tuple["Hyperparameters", ...]:
        """These and one step each way: what one window is searched for, warm-started from the last."""
        shorter, longer = max(self.length_scale / 2, 0.1), min(self.length_scale * 2, 100.0)
        cleaner, noisier = max(self.noise_ratio / 4, 1e-6), min(self.noise_ratio * 4, 100.0)
        return (
            self,
            Hyperparameters(shorter, self.noise_ratio),
            Hyperparameters(longer, self.noise_ratio),
            Hyperparameters(self.length_scale, cleaner),
            Hyperparameters(self.length_scale, noisier),
        )


@dataclass(frozen=True, eq=False)
class ExplicitBasisGP:
    """A fitted model: ask it for a value or a gradient.

    Attributes:
        centre: mean of the observed inputs, shape (d,); the polynomial is in ξ − centre.
        inputs: observed inputs minus the centre, shape (n, d).
        coefficients: β, shape (1 + degree d,): constant, linear, quadratic, … .
        weights: Kᵧ⁻¹ (y − Hβ) with Kᵧ in units of σ1², shape (n,).
        signal_variance: σ1².
    """

    centre: Float[Array, " d"]
    inputs: Float[Array, "n d"]
    coefficients: Float[Array, " m"]
    weights: Float[Array, " n"]
    hyperparameters: Hyperparameters
    signal_variance: float

    def predict(self, query: Float[Array, " d"]) -> float:
        """The mean at `query`."""
        offset = query - self.centre
        degree = (len(self.coefficients) - 1) // len(offset)
        polynomial = polynomial_basis(offset[None], degree)[0] @ self.coefficients
        return float(polynomial + self._kernel(offset) @ self.weights)

    def gradient(self, query: Float[Array, " d"]) -> Float[Array, " d"]:
        """The derivative of the mean with respect to the inputs, at `query`."""
        offset = query - self.centre
        by_power = self.coefficients[1:].reshape(-1, len(offset))
        polynomial = np.zeros_like(offset)
        for power, coefficients in enumerate(by_power, start=1):
            polynomial += power * coefficients * offset ** (power - 1)
        pull = self._kernel(offset) * self.weights
        return polynomial + pull @ (self.inputs - offset) / self.hyperparameters.length_scale**2

    def _kernel(self, offset: Float[Array, " d"]) -> Float[Array, " n"]:
        return correlation(np.sum((self.inputs - offset) ** 2, axis=-1), self.hyperparameters)


def polynomial_basis(inputs: Float[Array, "n d"], degree: int) -> Float[Array, "n m"]:
    """The basis {1, ξᵢ, ξᵢ², …, ξᵢ^degree} without cross terms, m = 1 + degree d, a row for each input."""
    powers = [inputs**power for power in range(1, degree + 1)]
    return np.hstack([np.ones((len(inputs), 1)), *powers])


def correlation(
    squared_distances: Float[Array, "*shape"], hyperparameters: Hyperparameters
) -> Float[Array, "*shape"]:
    """The squared-exponential kernel over σ1²."""
    return np.exp(squared_distances / (-2.0 * hyperparameters.length_scale**2))


def fit(
    inputs: Float[Array, "n d"],
    outputs: Float[Array, " n"],
    degree: int,
    candidates: Sequence[Hyperparameters],
) -> ExplicitBasisGP:
    """Fit the model under the likeliest of the candidates.

    The likelihood is concentrated: β and σ1² take the values that maximise it. As long as the polynomial
    alone goes through all the points, they say nothing about the kernel, and the first candidate stands.
    Coefficients that the points leave open take the smallest values that fit: the limit of a wide isotropic
    prior about zero.

    Args:
        inputs: ξ, one observation a row, in comparable units along all dimensions.
        outputs: what was observed there.
        degree: highest power in the basis.
        candidates: hyperparameters to choose from, at least one.
    """
    n = len(inputs)
    centre = inputs.mean(axis=0)
    centred = inputs - centre
    basis = polynomial_basis(centred, degree)
    if n <= basis.shape[1] + 1:
        candidates = candidates[:1]

    squared_distances = np.sum((centred[:, None] - centred[None]) ** 2, axis=-1)
    covariances = np.stack(
        [correlation(squared_distances, c) + c.noise_ratio * np.eye(n) for c in candidates]
    )
    factors = np.linalg.cholesky(covariances)
    whitened = np.linalg.solve(factors, np.column_stack([basis, outputs])[None])
    coefficients = _least_squares(whitened[..., :-1], whitened[..., -1])
    residuals = whitened[..., -1] - np.einsum("cnm,cm->cn", whitened[..., :-1], coefficients)

    # Noise-free data leave residuals of rounding, possibly none at all: the floor keeps the logarithm finite.
    floor = (np.finfo(float).eps * np.max(np.abs(outputs))) ** 2 + np.finfo(float).tiny
    variances = np.maximum(np.mean(residuals**2, axis=-1), floor)
    log_determinants = 2.0 * np.sum(np.log(np.diagonal(factors, axis1=1, axis2=2)), axis=-1)
    best = int(np.argmin(n * np.log(variances) + log_determinants))
    return ExplicitBasisGP(
        centre=centre,
        inputs=centred,
        coefficients=coefficients[best],
        weights=np.linalg.solve(factors[best].T, residuals[best]),
        hyperparameters=candidates[best],
        signal_variance=float(variances[best]),
    )


def _least_squares(matrices: Float[Array, "c n m"], targets: Float[Array, "c n"]) -> Float[Array, "c m"]:
    """The shortest least-squares solutions of a stack of systems, by singular values."""
    left, singular, right = np.linalg.svd(matrices, full_matrices=False)
    determined = singular > CUTOFF * singular[:, :1]
    inverse = np.divide(1.0, singular, out=np.zeros_like(singular), where=determined)
    projected = inverse * np.einsum("cnk,cn->ck", left, targets)
    coefficients: Array = np.einsum("ckm,ck->cm", right, projected)
    return coefficients
