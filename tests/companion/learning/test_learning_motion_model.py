import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.stats import multivariate_normal

from companion.arrays import Vec3
from companion.learning.error_prediction import Step
from companion.learning.features import Preview
from companion.learning.gaussian_process import Kernel
from companion.learning.motion_model import (
    LinearKernel,
    MotionModel,
    fit_weights,
    likeliest_kernel,
    log_likelihoods,
)
from companion.learning.online_model import online_model
from companion.learning.online_settings import DEFAULT, OnlineSettings

KERNEL = LinearKernel(prior_variance=1.0, noise_variance=1e-8)
LEADS_S = np.array((0.4, 0.3, 0.2))
PREVIEW = Preview(position_s=(0.4, 0.3, 0.2), velocity_s=(0.3, 0.2, 0.1))


def random_step(rng: np.random.Generator, where: float = 0.0) -> Step:
    position = rng.normal(size=3) + where
    state = np.concatenate((position, rng.normal(scale=0.3, size=9)))
    reference_position, reference_velocity, desired_position, *others = rng.normal(size=(8, 3))
    return Step(
        state, position + reference_position, reference_velocity, position + desired_position, *others
    )


def outcome(step: Step) -> Vec3:
    """Where a vehicle of which each axis pulls, accelerates and drifts in its own way comes to be."""
    position, velocity = step.state[:3], step.state[3:6]
    pull = np.array((0.5, 1.0, 2.0)) * (step.reference_position - position) + step.reference_acceleration
    pull += 0.6 * step.underway
    going_on = np.array((0.9, 0.5, 0.1)) * step.acceleration
    return position + LEADS_S * (velocity + 0.7 * step.drift) + 0.5 * LEADS_S**2 * (pull + going_on)


def velocity_after(step: Step) -> Vec3:
    return 0.6 * step.state[3:6] + 0.4 * step.reference_velocity


def trained(window: int = 60, where: float = 0.0, kernel: LinearKernel = KERNEL) -> MotionModel:
    model = MotionModel(kernel, window, PREVIEW)
    rng = np.random.default_rng(0)
    for _ in range(60):
        step = random_step(rng, where)
        assert model.learn(step, outcome(step), velocity_after(step))
    return model


def test_a_model_that_knows_nothing_expects_constant_velocity() -> None:
    step = random_step(np.random.default_rng(1))
    predicted = MotionModel(KERNEL, 10, PREVIEW).predict(step)
    np.testing.assert_array_equal(predicted.position, step.state[:3] + LEADS_S * step.state[3:6])
    np.testing.assert_array_equal(predicted.velocity, step.state[3:6])
    np.testing.assert_array_equal(predicted.gradient, np.zeros((3, 3)))
    assert predicted.variance > 0.01


def test_what_is_linear_is_learned() -> None:
    step = random_step(np.random.default_rng(2))
    predicted = trained().predict(step)
    np.testing.assert_allclose(predicted.position, outcome(step), atol=1e-5)
    np.testing.assert_allclose(predicted.velocity, velocity_after(step), atol=1e-5)
    np.testing.assert_allclose(predicted.error, step.desired_position - outcome(step), atol=1e-5)
    np.testing.assert_allclose(
        predicted.velocity_error, step.desired_velocity - velocity_after(step), atol=1e-5
    )
    assert predicted.variance < 1e-6


def test_the_gradient_is_that_of_the_error() -> None:
    model, step, small = trained(), random_step(np.random.default_rng(3)), 1e-4
    for axis, unit in enumerate(np.eye(3)):
        ahead, behind = (
            model.predict(
                step._replace(reference_position=step.reference_position + sign * small * unit)
            ).error
            for sign in (1.0, -1.0)
        )
        gradient = model.predict(step).gradient[:, axis]
        np.testing.assert_allclose(gradient, (ahead - behind) / (2.0 * small), atol=1e-8)


@given(st.floats(-1000.0, 1000.0))
def test_it_holds_wherever_it_is_flown(where: float) -> None:
    near = trained_here.predict(random_step(np.random.default_rng(4)))
    far = trained_here.predict(random_step(np.random.default_rng(4), where))
    np.testing.assert_allclose(far.error, near.error, atol=1e-9)


trained_here = trained()


def test_noise_alone_does_not_pull_it_from_constant_velocity() -> None:
    model = MotionModel(LinearKernel(prior_variance=1.0, noise_variance=0.02), 500, Preview.of_time(0.36))
    rng = np.random.default_rng(5)
    for _ in range(500):
        step = random_step(rng)
        constant = step.state[:3] + 0.36 * step.state[3:6]
        model.learn(step, constant + 0.05 * rng.normal(size=3), step.state[3:6])
    step = random_step(rng)
    shift = model.predict(step).position - step.state[:3] - 0.36 * step.state[3:6]
    assert np.linalg.norm(shift) < 0.05


def test_the_weights_are_those_of_ridge_regression() -> None:
    rng = np.random.default_rng(6)
    inputs, outputs = rng.normal(size=(20, 3, 5)), rng.normal(size=(20, 3, 2))
    weights = fit_weights(inputs, outputs, LinearKernel(prior_variance=0.5, noise_variance=0.2))
    for axis in range(3):
        augmented = np.vstack((inputs[:, axis], np.sqrt(0.4) * np.eye(5)))
        expected = np.linalg.lstsq(augmented, np.vstack((outputs[:, axis], np.zeros((5, 2)))), rcond=None)[0]
        np.testing.assert_allclose(weights.mean[axis], expected, atol=1e-12)
        covariance = 0.2 * np.linalg.inv(augmented.T @ augmented)
        np.testing.assert_allclose(weights.covariance[axis], covariance, atol=1e-12)


def test_the_gradient_is_as_uncertain_as_its_weight() -> None:
    """The error of a vehicle at rest, its reference moved aside by d, varies by d² var G."""
    model = trained(window=8, kernel=LinearKernel(prior_variance=1.0, noise_variance=0.1))
    still = Step(np.zeros(12), *np.zeros((8, 3)))
    beside = still._replace(reference_position=np.array((0.0, 0.5, 0.0)))
    predicted = model.predict(beside)
    assert predicted.variance == pytest.approx(0.25 * predicted.gradient_variance[1])
    assert (trained(window=60).predict(still).gradient_variance < predicted.gradient_variance).all()


@given(st.integers(0, 10_000), st.integers(1, 12), st.floats(0.01, 10.0))
def test_likelihoods_are_those_of_the_whole_covariance(seed: int, n: int, prior_variance: float) -> None:
    rng = np.random.default_rng(seed)
    inputs, outputs = rng.normal(size=(n, 3, 5)), rng.normal(size=(n, 3, 2))
    levels = np.array((0.05, 0.5, 5.0))
    expected = np.zeros(3)
    for axis in range(3):
        signal = prior_variance * inputs[:, axis] @ inputs[:, axis].T
        for k, level in enumerate(levels):
            process = multivariate_normal(cov=signal + level * np.eye(n))
            expected[k] += np.sum(process.logpdf(outputs[:, axis].T))
    found = log_likelihoods(inputs, outputs, prior_variance, levels)
    np.testing.assert_allclose(np.diff(found), np.diff(expected), rtol=1e-6, atol=1e-6)


@pytest.mark.parametrize(("true", "found"), [(1e-9, 0.002), (0.004, 0.004), (0.05, 0.05), (100.0, 0.2)])
def test_the_noise_is_found_within_reach(true: float, found: float) -> None:
    rng = np.random.default_rng(9)
    inputs = rng.normal(size=(500, 3, 5))
    outputs = np.einsum("nad,adm->nam", inputs, rng.normal(size=(3, 5, 2)))
    outputs += np.sqrt(true) * rng.normal(size=outputs.shape)
    kernel = LinearKernel(prior_variance=1.0, noise_variance=0.02, noise="fitted")
    assert likeliest_kernel(inputs, outputs, kernel).noise_variance == pytest.approx(found, rel=0.3)


def test_a_fitted_noise_knows_better_what_it_knows() -> None:
    given, fitted = (
        trained(kernel=LinearKernel(prior_variance=1.0, noise_variance=0.02, noise=noise))
        for noise in ("given", "fitted")
    )
    step = random_step(np.random.default_rng(10))
    assert fitted.predict(step).variance < 0.2 * given.predict(step).variance
    error, given_error = (
        np.linalg.norm(model.predict(step).position - outcome(step)) for model in (fitted, given)
    )
    assert error < given_error


def test_only_the_window_counts() -> None:
    model = trained(window=20)
    rng = np.random.default_rng(7)
    for _ in range(20):
        step = random_step(rng)
        model.learn(step, step.state[:3] + LEADS_S * step.state[3:6], step.state[3:6])
    step = random_step(rng)
    np.testing.assert_allclose(
        model.predict(step).position, step.state[:3] + LEADS_S * step.state[3:6], atol=1e-12
    )
    assert len(model) == 20


def test_what_is_not_finite_is_not_learned() -> None:
    model, step = MotionModel(KERNEL, 5, PREVIEW), random_step(np.random.default_rng(8))
    assert not model.learn(step, np.array([0.0, np.nan, 0.0]), np.zeros(3))
    assert not model.learn(step._replace(reference_position=np.full(3, np.inf)), np.zeros(3), np.zeros(3))
    assert len(model) == 0
    assert np.isnan(model.predict(step._replace(drift=np.full(3, np.nan))).position).all()


def test_settings_choose_the_model() -> None:
    assert isinstance(online_model(DEFAULT), MotionModel)
    assert not isinstance(online_model(DEFAULT.model_copy(update=SQUARED_EXPONENTIAL)), MotionModel)


SQUARED_EXPONENTIAL = {
    "form": "displacement",
    "kernel": Kernel(prior_variance=1.0, length_scale=20.0, noise_variance=2e-5),
}


@pytest.mark.parametrize(
    "wrong",
    [
        {"form": "displacement"},
        {"kernel": {"prior_variance": 1.0, "length_scale": 20.0, "noise_variance": 2e-5}},
        {"preview": {"position_s": (0.1, 0.0, 0.1), "velocity_s": (0.1, 0.1, 0.1)}},
    ],
)
def test_settings_that_do_not_fit_are_refused(wrong: dict[str, object]) -> None:
    with pytest.raises(ValueError, match="form motion"):
        OnlineSettings.model_validate(DEFAULT.model_dump() | wrong)
