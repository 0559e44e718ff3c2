"""Nonlinear least squares by Levenberg and Marquardt's damping.

This is how toolboxes commonly train networks of this size (Hagan & Menhaj, Training feedforward networks
with the Marquardt algorithm, IEEE Transactions on Neural Networks 5(6), 1994). The damped normal equations
are solved by a Cholesky factor; `scipy.optimize.least_squares` decomposes the Jacobian itself, which for
1,500 residuals by 941 parameters takes several times as long a step.
"""

from collections.abc import Callable

import numpy as np
from jaxtyping import Float
from scipy.linalg import cho_factor, cho_solve

from companion.arrays import Array

MIN_DAMPING, MAX_DAMPING = 1e-8, 1e10


def minimise(
    residuals: Callable[[Float[Array, " p"]], Float[Array, " n"]],
    jacobian: Callable[[Float[Array, " p"]], Float[Array, "n p"]],
    start: Float[Array, " p"],
    *,
    tolerance: float,
    max_iterations: int = 60,
) -> Float[Array, " p"]:
    """Parameters that make the residuals small.

    Stops when their root mean square is below `tolerance`, when no step improves on it any more, or after
    `max_iterations`.
    """
    parameters, damping = start, 1e-3
    errors = residuals(parameters)
    for _ in range(max_iterations):
        if np.sqrt(np.mean(errors**2)) < tolerance:
            break
        J = jacobian(parameters)
        hessian, slope = J.T @ J, J.T @ errors
        while damping <= MAX_DAMPING:
            factor = cho_factor(hessian + damping * np.eye(len(parameters)))
            candidate = parameters - cho_solve(factor, slope)
            candidate_errors = residuals(candidate)
            if candidate_errors @ candidate_errors < errors @ errors:
                break
            damping *= 10.0
        else:
            break
        parameters, errors = candidate, candidate_errors
        damping = max(damping / 10.0, MIN_DAMPING)
    return parameters
