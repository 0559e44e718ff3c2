import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from sklearn.gaussian_process import GaussianProcessRegressor
from sklearn.gaussian_process.kernels import RBF, ConstantKernel, WhiteKernel

from companion.arrays import Array
from companion.learning.gaussian_process import Kernel, SlidingWindow, fit, gradient_variance, predict

PAPER_KERNEL = Kernel(prior_variance=1.0, length_scale=20.0, noise_variance=2e-5)


def samples(seed: int, n: int, d: int, m: int = 3) -> tuple[Array, Array]:
    rng = np.random.default_rng(seed)
    return rng.normal(size=(n, d)), rng.normal(size=(n, m))


def sklearn_kernel(kernel: Kernel) -> object:
    return ConstantKernel(kernel.prior_variance) * RBF(kernel.length_scale) + WhiteKernel(
        kernel.noise_variance
    )


Problem = tuple[Array, Array, Kernel]


@st.composite
def problems(draw: st.DrawFn) -> Problem:
    """Observations and a kernel, with one length scale or one for each input."""
    dimensions = draw(st.integers(1, 24))
    inputs, outputs = samples(draw(st.integers(0, 10_000)), draw(st.integers(1, 40)), dimensions)
    length = st.floats(0.3, 20.0)
    kernel = Kernel(
        prior_variance=draw(st.floats(0.1, 10.0)),
        length_scale=draw(length | st.tuples(*[length] * dimensions)),
        noise_variance=draw(st.floats(2e-5, 1e-1)),
    )
    return inputs, outputs, kernel


@settings(max_examples=50, deadline=None)
@given(problems())
def test_prediction_equals_sklearn(problem: Problem) -> None:
    inputs, outputs, kernel = problem
    at = samples(1, 1, inputs.shape[1])[0][0]
    theirs = GaussianProcessRegressor(
        ConstantKernel(kernel.prior_variance) * RBF(kernel.length_scale),
        alpha=kernel.noise_variance,
        optimizer=None,
    ).fit(inputs, outputs)
    mean, deviation = theirs.predict(at[None], return_std=True)
    ours = predict(fit(inputs, outputs, kernel), at)
    np.testing.assert_allclose(ours.mean, mean[0], rtol=1e-8, atol=1e-8)
    # sklearn clips its own rounding to zero, and the root of 1e-16 is 1e-8
    np.testing.assert_allclose(ours.variance, deviation[0, 0] ** 2, rtol=1e-8, atol=1e-10)


@settings(max_examples=50, deadline=None)
@given(problems())
def test_gradient_variance_is_that_of_differences(problem: Problem) -> None:
    inputs, outputs, kernel = problem
    at, small = samples(2, 1, inputs.shape[1])[0][0], 1e-2
    theirs = GaussianProcessRegressor(
        ConstantKernel(kernel.prior_variance) * RBF(kernel.length_scale),
        alpha=kernel.noise_variance,
        optimizer=None,
    ).fit(inputs, outputs[:, 0])
    ours = gradient_variance(fit(inputs, outputs, kernel), at, slice(0, 2))
    for unit, variance in zip(np.eye(len(at)), ours, strict=False):
        _, covariance = theirs.predict(at + small * np.array([[-1.0], [1.0]]) * unit, return_cov=True)
        between = covariance[0, 0] + covariance[1, 1] - 2.0 * covariance[0, 1]
        assert variance == pytest.approx(between / (2.0 * small) ** 2, rel=1e-2, abs=1e-7)


def test_a_gradient_of_which_nothing_is_known_varies_as_the_prior_does() -> None:
    kernel = Kernel(prior_variance=2.0, length_scale=(1.0, 2.0, 4.0), noise_variance=0.1)
    nothing = fit(np.empty((0, 3)), np.empty((0, 1)), kernel)
    np.testing.assert_allclose(gradient_variance(nothing, np.zeros(3), slice(1, 3)), [0.5, 0.125])
    far = fit(np.full((1, 3), 1e3), np.zeros((1, 1)), kernel)
    np.testing.assert_allclose(gradient_variance(far, np.zeros(3), slice(1, 3)), [0.5, 0.125])


@settings(max_examples=50, deadline=None)
@given(problems())
def test_gradient_equals_finite_differences(problem: Problem) -> None:
    inputs, outputs, kernel = problem
    posterior = fit(inputs, outputs, kernel)
    at = samples(2, 1, inputs.shape[1])[0][0]
    step = 1e-4
    differences = [
        (predict(posterior, at + step * unit).mean - predict(posterior, at - step * unit).mean) / (2 * step)
        for unit in np.eye(len(at))
    ]
    scale = max(1.0, float(np.abs(posterior.weights).sum()) * kernel.prior_variance)
    np.testing.assert_allclose(
        predict(posterior, at).gradient, np.array(differences).T, rtol=1e-5, atol=1e-7 * scale
    )


def test_with_no_observation_there_is_only_the_prior() -> None:
    prediction = predict(fit(np.empty((0, 4)), np.empty((0, 3)), PAPER_KERNEL), np.ones(4))
    np.testing.assert_array_equal(prediction.mean, np.zeros(3))
    np.testing.assert_array_equal(prediction.gradient, np.zeros((3, 4)))
    assert prediction.variance == 1.0


def test_repeated_observations_without_noise_are_survived() -> None:
    kernel = Kernel(prior_variance=1.0, length_scale=20.0, noise_variance=1e-300)
    posterior = fit(np.ones((40, 4)), np.ones((40, 1)), kernel)
    assert 0.0 < posterior.jitter < 1e-10
    assert predict(posterior, np.ones(4)).mean[0] == pytest.approx(1.0, abs=1e-6)


def test_a_query_that_is_not_finite_gives_nan() -> None:
    inputs, outputs = samples(5, 10, 4)
    prediction = predict(fit(inputs, outputs, PAPER_KERNEL), np.array([0.0, np.nan, 0.0, 0.0]))
    assert np.isnan(prediction.mean).all()


@given(st.integers(1, 6), st.integers(0, 20))
def test_the_window_holds_the_newest(size: int, taken: int) -> None:
    window = SlidingWindow(size, inputs=2, outputs=1)
    for number in range(taken):
        assert window.append(np.full(2, number), np.full(1, -number))
    newest = set(range(max(0, taken - size), taken))
    assert len(window) == len(newest)
    assert set(window.inputs[:, 0]) == newest
    np.testing.assert_array_equal(window.inputs[:, [1]], -window.outputs)


@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf, 1e7])
def test_the_window_refuses_what_no_vehicle_does(bad: float) -> None:
    window = SlidingWindow(3, inputs=2, outputs=1)
    assert not window.append(np.array([0.0, bad]), np.zeros(1))
    assert not window.append(np.zeros(2), np.array([bad]))
    assert len(window) == 0


def test_the_posterior_outlives_the_window() -> None:
    window = SlidingWindow(2, inputs=1, outputs=1)
    window.append(np.zeros(1), np.ones(1))
    window.append(np.ones(1), np.ones(1))
    posterior = fit(window.inputs, window.outputs, PAPER_KERNEL)
    before = predict(posterior, np.zeros(1)).mean
    window.append(np.full(1, 50.0), np.zeros(1))
    np.testing.assert_array_equal(predict(posterior, np.zeros(1)).mean, before)
