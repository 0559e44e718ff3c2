"""The inverse network of the linear experiment and the method that trains it."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

from companion.experiments.linear.experiment import SOURCE
from companion.experiments.linear.inverse import (
    _jacobian,
    _random_parameters,
    _unflatten,
    sinusoid_responses,
)
from companion.experiments.linear.levenberg_marquardt import minimise


def test_levenberg_marquardt_finds_the_minimum_of_rosenbrock() -> None:
    found = minimise(
        lambda p: np.array([10.0 * (p[1] - p[0] ** 2), 1.0 - p[0]]),
        lambda p: np.array([[-20.0 * p[0], 10.0], [-1.0, 0.0]]),
        np.array([-1.2, 1.0]),
        tolerance=1e-12,
    )
    assert_allclose(found, [1.0, 1.0], atol=1e-10)


def test_levenberg_marquardt_stops_where_nothing_improves() -> None:
    found = minimise(
        lambda p: np.array([p[0], 1.0]),
        lambda p: np.array([[1.0], [0.0]]),
        np.array([3.0]),
        tolerance=1e-3,
    )
    assert found[0] == pytest.approx(0.0, abs=1e-6)


def test_jacobian_is_the_difference_quotient() -> None:
    sizes = (3, 4, 5, 1)
    parameters = _random_parameters(sizes, np.random.default_rng(0))
    inputs = np.random.default_rng(1).standard_normal((6, 3))
    step = 1e-6 * np.eye(len(parameters))

    def outputs(p: np.ndarray) -> np.ndarray:
        activation = inputs
        layers = _unflatten(p, sizes)
        for weights, biases in layers[:-1]:
            activation = np.tanh(activation @ weights.T + biases)
        return (activation @ layers[-1][0].T + layers[-1][1])[:, 0]

    quotients = [(outputs(parameters + d) - outputs(parameters - d)) / 2e-6 for d in step]
    assert_allclose(_jacobian(_unflatten(parameters, sizes), inputs), np.transpose(quotients), atol=1e-8)


def test_training_data_are_the_response_to_25_sinusoids() -> None:
    inputs, references = sinusoid_responses(SOURCE, samples=40)
    assert inputs.shape == (25 * 40, 3)
    states, next_output = inputs[:, :2], inputs[:, 2]
    assert_allclose(states @ SOURCE.state_gain + SOURCE.input_gain * references, next_output, atol=1e-12)
