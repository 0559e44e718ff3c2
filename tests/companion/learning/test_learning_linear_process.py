"""The process with a linear kernel against the textbook's formulas, and whether it finds the noise."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.testing import assert_allclose

from companion.arrays import Array
from companion.learning.linear_process import fit_linear

SLOPES = np.array([0.5, -1.2, 0.8])


def _basis(n: int, seed: int) -> Array:
    return np.random.default_rng(seed).uniform(-1.0, 1.0, (n, 3))


def test_posterior_is_that_of_the_textbook() -> None:
    """Rasmussen & Williams (2006), equation 2.8, under the noise that was found."""
    basis, prior = _basis(20, 0), np.array([1.0, 2.0, 0.5])
    outputs = basis @ SLOPES + 0.1 * np.random.default_rng(1).standard_normal(20)
    posterior = fit_linear(basis, outputs, prior)
    precision = basis.T @ basis / posterior.noise**2 + np.diag(prior**-2)
    assert_allclose(posterior.covariance, np.linalg.inv(precision), rtol=1e-9)
    assert_allclose(posterior.mean, np.linalg.solve(precision, basis.T @ outputs / posterior.noise**2))


@pytest.mark.parametrize("noise", [1e-6, 1e-3, 0.1])
def test_noise_is_found(noise: float) -> None:
    basis = _basis(400, 2)
    outputs = basis @ SLOPES + noise * np.random.default_rng(3).standard_normal(400)
    assert noise / 2.0 < fit_linear(basis, outputs, np.ones(3)).noise < 2.0 * noise


def test_exact_observations_are_met_exactly() -> None:
    basis = _basis(10, 4)
    posterior = fit_linear(basis, basis @ SLOPES, np.ones(3))
    assert_allclose(posterior.mean, SLOPES, rtol=1e-9)
    assert np.max(np.abs(posterior.covariance)) < 1e-12


def test_what_was_never_seen_stays_as_uncertain_as_before() -> None:
    basis = _basis(10, 5) * [1.0, 1.0, 0.0]
    posterior = fit_linear(basis, basis @ SLOPES, np.array([1.0, 1.0, 0.7]))
    assert posterior.mean[2] == 0.0
    assert posterior.covariance[2, 2] == pytest.approx(0.49)


@given(st.integers(5, 12), st.floats(1e-6, 1e6))
def test_unit_of_the_outputs_does_not_matter(n: int, unit: float) -> None:
    basis = _basis(n, 6)
    outputs = basis @ SLOPES + 0.05 * np.random.default_rng(7).standard_normal(n)
    plain, scaled = (
        fit_linear(basis, outputs, np.ones(3)),
        fit_linear(basis, unit * outputs, unit * np.ones(3)),
    )
    assert_allclose(scaled.mean, unit * plain.mean, rtol=1e-6, atol=1e-9 * unit)
    assert scaled.noise == pytest.approx(unit * plain.noise)


def test_outputs_that_are_all_zero_say_so() -> None:
    basis = _basis(5, 8)
    posterior = fit_linear(basis, np.zeros(5), np.ones(3))
    assert np.all(posterior.mean == 0.0)
    assert np.all(np.isfinite(posterior.covariance))
