"""Exact Gaussian-process regression on the newest observations (Rasmussen and Williams 2006, chapter 2).

Zero prior mean, squared-exponential kernel, Gaussian noise; the outputs share the kernel and therefore its
Cholesky factor. A window of 40 observations is refitted from nothing at every step: that costs tens of
microseconds and cannot drift.
"""

from dataclasses import dataclass
from typing import Annotated, NamedTuple, TypeAlias

import numpy as np
from jaxtyping import Float
from pydantic import BaseModel, ConfigDict, Field, PositiveFloat
from scipy.linalg.lapack import dpotrf, dpotrs, dtrtrs

from companion.arrays import Array

LARGEST_OBSERVATION = 1e6
"""Beyond this (m, m/s, rad) an observation is a fault of the telemetry."""

LengthScale: TypeAlias = Annotated[float, Field(ge=1e-6, le=1e9)]
"""Of which the square, and what is divided by it, are numbers, too."""


class Kernel(BaseModel):
    """k(ξ, ξ') = σ1² exp(−½ Σ (ξ_i − ξ_i')² / l_i²), with noise of variance σ2² on each observation.

    Attributes:
        prior_variance: σ1², in the outputs' unit squared.
        length_scale: l, one for all inputs or one for each, in the inputs' units.
        noise_variance: σ2², in the outputs' unit squared.
    """

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)

    prior_variance: Annotated[float, Field(gt=0.0, le=1e9)]
    length_scale: LengthScale | tuple[LengthScale, ...]
    noise_variance: PositiveFloat


class SlidingWindow:
    """The newest observations (ξ, output), at most `size` of them; the oldest makes room for the next."""

    def __init__(self, size: int, inputs: int, outputs: int) -> None:
        self._inputs = np.empty((size, inputs))
        self._outputs = np.empty((size, outputs))
        self._taken = 0

    def __len__(self) -> int:
        return min(self._taken, len(self._inputs))

    @property
    def inputs(self) -> Float[Array, "n d"]:
        """The inputs, in no order; a view."""
        return self._inputs[: len(self)]

    @property
    def outputs(self) -> Float[Array, "n m"]:
        """The outputs, row by row those of `inputs`; a view."""
        return self._outputs[: len(self)]

    def append(self, inputs: Float[Array, " d"], outputs: Float[Array, " m"]) -> bool:
        """Take one observation; False, and nothing taken, if it is not finite or absurdly large."""
        if not (np.abs(inputs).max() <= LARGEST_OBSERVATION and np.abs(outputs).max() <= LARGEST_OBSERVATION):
            return False  # NaN comes here too: it compares as false
        row = self._taken % len(self._inputs)
        self._inputs[row] = inputs
        self._outputs[row] = outputs
        self._taken += 1
        return True


@dataclass(frozen=True, eq=False)
class Posterior:
    """A Gaussian process that has seen its observations.

    Attributes:
        kernel: its hyperparameters.
        inputs: the observed inputs, (n, d).
        factor: lower Cholesky factor of K + σ2² I, (n, n); above the diagonal, rubbish.
        weights: (K + σ2² I)⁻¹ outputs, (n, m).
        jitter: what had to be added to the diagonal besides σ2² to factor it; 0 unless σ2² is tiny.
    """

    kernel: Kernel
    inputs: Float[Array, "n d"]
    factor: Float[Array, "n n"]
    weights: Float[Array, "n m"]
    jitter: float


class Prediction(NamedTuple):
    """What the process expects at one input.

    Attributes:
        mean: (m,).
        variance: of the noise-free function, the same for each output; σ1² where nothing is known.
        gradient: ∂mean/∂ξ, (m, d).
    """

    mean: Float[Array, " m"]
    variance: float
    gradient: Float[Array, "m d"]


def _scaled_distances(inputs: Float[Array, "n d"], kernel: Kernel) -> Float[Array, "n n"]:
    """Σ_i (ξ_i − ξ_i')² / l_i² between every two inputs."""
    centred = (inputs - inputs.mean(axis=0)) / np.asarray(kernel.length_scale)
    products = centred @ centred.T
    norms = np.diag(products)
    distances: Float[Array, "n n"] = np.maximum(norms[:, None] + norms - 2.0 * products, 0.0)
    return distances


def _factorise(covariance: Float[Array, "n n"], noise_variance: float) -> tuple[Float[Array, "n n"], float]:
    """Lower Cholesky factor of covariance + noise I, and the jitter that had to be added for it to exist.

    Jitter starts at the rounding error of the diagonal and grows a hundredfold until LAPACK's potrf succeeds,
    which it does for every finite covariance.
    """
    identity = np.eye(len(covariance))
    factor, failed = dpotrf(covariance + noise_variance * identity, lower=1, clean=0)
    jitter = 0.0
    while failed:
        jitter = max(100.0 * jitter, float(np.trace(covariance)) * np.finfo(float).eps)
        factor, failed = dpotrf(covariance + (noise_variance + jitter) * identity, lower=1, clean=0)
    return factor, jitter


def fit(inputs: Float[Array, "n d"], outputs: Float[Array, "n m"], kernel: Kernel) -> Posterior:
    """Condition the process on finite observations, none included (Rasmussen and Williams, algorithm 2.1)."""
    if len(inputs) == 0:
        return Posterior(kernel, inputs.copy(), np.empty((0, 0)), outputs.copy(), jitter=0.0)
    covariance = kernel.prior_variance * np.exp(-0.5 * _scaled_distances(inputs, kernel))
    factor, jitter = _factorise(covariance, kernel.noise_variance)
    weights, _ = dpotrs(factor, outputs, lower=1)
    return Posterior(kernel, inputs.copy(), factor, weights, jitter)


def predict(posterior: Posterior, at: Float[Array, " d"]) -> Prediction:
    """Mean, variance and gradient of the mean at one input; NaN, never an error, if that is not finite."""
    kernel = posterior.kernel
    length_scale = np.asarray(kernel.length_scale)
    offsets = (posterior.inputs - at) / length_scale
    covariance = kernel.prior_variance * np.exp(-0.5 * np.einsum("nd,nd->n", offsets, offsets))
    mean = covariance @ posterior.weights
    gradient = (covariance[:, None] * posterior.weights).T @ (offsets / length_scale)
    if len(covariance) == 0:
        return Prediction(mean, kernel.prior_variance, gradient)
    whitened, _ = dtrtrs(posterior.factor, covariance, lower=1)
    variance = kernel.prior_variance - float(whitened @ whitened)
    return Prediction(mean, max(variance, 0.0), gradient)


def gradient_variance(posterior: Posterior, at: Float[Array, " d"], of: slice) -> Float[Array, " g"]:
    """Variance of ∂f/∂ξ at one input, the same for each output, for the entries `of` ξ.

    σ1²/l² where nothing is known (Rasmussen and Williams, section 9.4); NaN where the input is not finite.
    """
    kernel = posterior.kernel
    length_scale = np.broadcast_to(kernel.length_scale, at.shape)
    prior: Float[Array, " g"] = kernel.prior_variance / length_scale[of] ** 2
    if len(posterior.inputs) == 0:
        return prior
    offsets = (posterior.inputs - at) / length_scale
    covariance = kernel.prior_variance * np.exp(-0.5 * np.einsum("nd,nd->n", offsets, offsets))
    whitened, _ = dtrtrs(posterior.factor, covariance[:, None] * (offsets / length_scale)[:, of], lower=1)
    posterior_variance: Float[Array, " g"] = np.maximum(prior - np.sum(whitened**2, axis=0), 0.0)
    return posterior_variance
