"""Hyperparameters of the Gaussian process by marginal likelihood (Rasmussen and Williams 2006, 5.4.1).

Every hyperparameter is positive, and handled by its logarithm: θ = log(σ1², l_1, …, σ2²), with one l or one
for each input, as the kernel has it.
"""

import numpy as np
from jaxtyping import Float
from scipy.linalg.lapack import dpotri, dpotrs
from scipy.optimize import minimize

from companion.arrays import Array
from companion.learning.gaussian_process import Kernel, factorise, scaled_distances

MOST_DECADES = 3.0
"""How far optimisation may take a hyperparameter from where it starts, either way."""


def log_hyperparameters(kernel: Kernel) -> Float[Array, " p"]:
    """θ of a kernel."""
    theta: Float[Array, " p"] = np.log(
        np.hstack((kernel.prior_variance, kernel.length_scale, kernel.noise_variance))
    )
    return theta


def kernel_of(theta: Float[Array, " p"]) -> Kernel:
    """The kernel of θ, with one length scale if θ has three entries."""
    prior_variance, *length_scales, noise_variance = np.exp(theta).tolist()
    length_scale = length_scales[0] if len(length_scales) == 1 else tuple(length_scales)
    return Kernel(prior_variance=prior_variance, length_scale=length_scale, noise_variance=noise_variance)


def log_marginal_likelihood(
    inputs: Float[Array, "n d"], outputs: Float[Array, "n m"], kernel: Kernel
) -> tuple[float, Float[Array, " p"]]:
    """Log p(outputs | inputs, θ), summed over the outputs, and its gradient with respect to θ.

    Rasmussen and Williams, equations 5.8 and 5.9; n at least 1.
    """
    distances = scaled_distances(inputs, kernel)
    covariance = kernel.prior_variance * np.exp(-0.5 * distances)
    factor, _ = factorise(covariance, kernel.noise_variance)
    weights, _ = dpotrs(factor, outputs, lower=1)
    observations, columns = outputs.shape
    likelihood = (
        -0.5 * float(np.sum(outputs * weights))
        - columns * float(np.sum(np.log(np.diag(factor))))
        - 0.5 * columns * observations * np.log(2.0 * np.pi)
    )
    inverse = np.tril(dpotri(factor, lower=1)[0])
    inverse += np.tril(inverse, -1).T
    slope = 0.5 * (weights @ weights.T - columns * inverse)
    by_length = _by_log_length(inputs, kernel, covariance * slope, distances)
    gradient = np.hstack((np.sum(slope * covariance), by_length, kernel.noise_variance * np.trace(slope)))
    return likelihood, gradient


def _by_log_length(
    inputs: Float[Array, "n d"],
    kernel: Kernel,
    weighted: Float[Array, "n n"],
    distances: Float[Array, "n n"],
) -> Float[Array, " l"]:
    """∂/∂log l_i: the covariance, weighted by its slope, times the share of input i in the distances."""
    if not isinstance(kernel.length_scale, tuple):
        return np.sum(weighted * distances, keepdims=True).ravel()
    scaled = (inputs - inputs.mean(axis=0)) / np.asarray(kernel.length_scale)
    # Σ_ab W_ab (z_a − z_b)² = 2 Σ_a (Σ_b W_ab) z_a² − 2 zᵀ W z, for symmetric W
    crosswise = np.einsum("ai,ab,bi->i", scaled, weighted, scaled, optimize=True)
    by_length: Float[Array, " l"] = 2.0 * (weighted.sum(axis=1) @ scaled**2 - crosswise)
    return by_length


def fitted_kernel(
    inputs: Float[Array, "n d"], outputs: Float[Array, "n m"], start: Kernel, most_evaluations: int = 30
) -> Kernel:
    """The kernel of the highest marginal likelihood near `start`, never less likely than `start` itself.

    L-BFGS-B with the analytic gradient, each hyperparameter within `MOST_DECADES` of its start, and at most
    about `most_evaluations` likelihoods: bounded in time, to be started from the last result.
    """
    theta = log_hyperparameters(start)
    reach = MOST_DECADES * np.log(10.0)

    def cost(at: Float[Array, " p"]) -> tuple[float, Float[Array, " p"]]:
        likelihood, gradient = log_marginal_likelihood(inputs, outputs, kernel_of(at))
        return -likelihood, -gradient

    found = minimize(
        cost,
        theta,
        jac=True,
        method="L-BFGS-B",
        bounds=[(value - reach, value + reach) for value in theta],
        options={"maxfun": most_evaluations},
    )
    return kernel_of(found.x) if found.fun < cost(theta)[0] else start
