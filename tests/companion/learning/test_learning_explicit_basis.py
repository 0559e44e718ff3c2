"""The explicit-basis GP against the textbook's formulas, on data on which these are well conditioned."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

from companion.arrays import Array
from companion.learning.explicit_basis import (
    ExplicitBasisGP,
    Hyperparameters,
    fit,
    polynomial_basis,
)

HYPERPARAMETERS = Hyperparameters(length_scale=0.7, noise_ratio=0.05)


def _data(n: int = 25, seed: int = 0) -> tuple[Array, Array]:
    rng = np.random.default_rng(seed)
    inputs = rng.uniform(-1.0, 1.0, (n, 3))
    return inputs, np.sin(2.0 * inputs[:, 0]) + inputs[:, 1] * inputs[:, 2] + 0.01 * rng.standard_normal(n)


def _kernel(a: Array, b: Array, length_scale: float) -> Array:
    distances = np.sum((a[:, None] - b[None]) ** 2, axis=-1)
    kernel: Array = np.exp(-0.5 * distances / length_scale**2)
    return kernel


def _textbook_mean(inputs: Array, outputs: Array, query: Array, degree: int, signal_variance: float) -> float:
    """Rasmussen & Williams (2006), section 2.7, equation 2.42 in the limit of a vague prior, as printed."""
    H = polynomial_basis(inputs, degree).T
    h = polynomial_basis(query[None], degree).T
    noise_variance = HYPERPARAMETERS.noise_ratio * signal_variance
    K = signal_variance * _kernel(inputs, inputs, HYPERPARAMETERS.length_scale)
    k = signal_variance * _kernel(inputs, query[None], HYPERPARAMETERS.length_scale)
    inverse = np.linalg.inv(K + noise_variance * np.eye(len(inputs)))
    beta = np.linalg.inv(H @ inverse @ H.T) @ H @ inverse @ outputs
    remainder = h - H @ inverse @ k
    return float((k.T @ inverse @ outputs + remainder.T @ beta)[0])


def _log_likelihood(inputs: Array, outputs: Array, model: ExplicitBasisGP, signal_variance: float) -> float:
    """log p(y | X, β, θ) of the Gaussian with mean Hβ, as printed."""
    hyperparameters = model.hyperparameters
    K = _kernel(inputs, inputs, hyperparameters.length_scale) + hyperparameters.noise_ratio * np.eye(
        len(inputs)
    )
    basis = polynomial_basis(inputs - model.centre, (len(model.coefficients) - 1) // inputs.shape[1])
    residual = outputs - basis @ model.coefficients
    _, log_determinant = np.linalg.slogdet(2.0 * np.pi * signal_variance * K)
    return float(-0.5 * residual @ np.linalg.solve(signal_variance * K, residual) - 0.5 * log_determinant)


@pytest.mark.parametrize("degree", [1, 2])
@pytest.mark.parametrize("signal_variance", [0.1, 3.0])
def test_mean_is_that_of_the_textbook(degree: int, signal_variance: float) -> None:
    inputs, outputs = _data()
    model = fit(inputs, outputs, degree, [HYPERPARAMETERS])
    for query in np.random.default_rng(1).uniform(-1.5, 1.5, (5, 3)):
        expected = _textbook_mean(inputs, outputs, query, degree, signal_variance)
        assert model.predict(query) == pytest.approx(expected, rel=1e-9, abs=1e-10)


@pytest.mark.parametrize("degree", [1, 2])
def test_gradient_is_the_difference_quotient(degree: int) -> None:
    inputs, outputs = _data()
    model = fit(inputs, outputs, degree, [HYPERPARAMETERS])
    query, step = np.array([0.3, -0.2, 0.9]), 1e-5
    quotients = [
        (model.predict(query + offset) - model.predict(query - offset)) / (2.0 * step)
        for offset in step * np.eye(3)
    ]
    assert_allclose(model.gradient(query), quotients, atol=1e-8)


def test_signal_variance_maximises_the_likelihood() -> None:
    inputs, outputs = _data()
    model = fit(inputs, outputs, 1, [HYPERPARAMETERS])
    best = _log_likelihood(inputs, outputs, model, model.signal_variance)
    for factor in (0.9, 1.1):
        assert _log_likelihood(inputs, outputs, model, factor * model.signal_variance) < best


def test_the_likeliest_candidate_is_chosen() -> None:
    inputs, outputs = _data()
    candidates = HYPERPARAMETERS.neighbourhood()
    likelihoods = []
    for candidate in candidates:
        alone = fit(inputs, outputs, 1, [candidate])
        likelihoods.append(_log_likelihood(inputs, outputs, alone, alone.signal_variance))
    chosen = fit(inputs, outputs, 1, candidates).hyperparameters
    assert chosen == candidates[int(np.argmax(likelihoods))]
    assert chosen != candidates[0]


def test_few_points_leave_the_hyperparameters_and_are_met_by_the_shortest_polynomial() -> None:
    inputs = np.array([[1.0, 0.0, 0.0], [2.0, 0.0, 0.0]])
    model = fit(inputs, np.array([-1.0, 1.0]), 1, HYPERPARAMETERS.neighbourhood())
    assert model.hyperparameters == HYPERPARAMETERS
    assert_allclose(model.coefficients, [0.0, 2.0, 0.0, 0.0], atol=1e-12)


def test_nearly_collinear_points_determine_the_slope_to_many_digits() -> None:
    along = np.linspace(0.0, 0.02, 15)
    wiggle = 1e-7 * np.random.default_rng(0).choice([-1.0, 1.0], 15)
    inputs = np.column_stack([along, 0.9 * along, along + wiggle])
    slope = np.array([-0.24, 0.9, 1.0])
    model = fit(inputs, inputs @ slope, 1, Hyperparameters().neighbourhood())
    assert model.gradient(inputs[-1])[2] == pytest.approx(slope[2], abs=1e-7)


def test_outputs_that_are_all_zero_predict_zero() -> None:
    inputs, _ = _data()
    model = fit(inputs, np.zeros(len(inputs)), 1, HYPERPARAMETERS.neighbourhood())
    assert model.predict(np.array([0.1, 0.2, 0.3])) == 0.0
