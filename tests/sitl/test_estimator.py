import math
from typing import Any

import numpy as np
import pytest

from sitl.arrays import Array
from sitl.estimator import Estimator, compose, draw, reset, wander
from sitl.estimator import estimator as estimator_with
from sitl.estimator_errors import EstimatorErrors
from sitl.quaternion import from_rotation_vector, multiply

TRUTH = np.zeros(13)
TRUTH[0:6] = (1.0, -2.0, -3.0, 0.5, 0.6, -0.7)
TRUTH[6:10] = from_rotation_vector(np.array((0.3, -0.2, 1.0)))
TRUTH[10:13] = (0.1, 0.2, 0.3)


def estimator(errors: EstimatorErrors, motion: Array, seed: int) -> Estimator:
    return estimator_with(errors, motion, np.random.default_rng(seed), np.random.default_rng(seed + 1))


def conditions(**channels: dict[str, float] | float) -> EstimatorErrors:
    return EstimatorErrors.model_validate(channels)


def errors(estimate: Estimator, channel: int, steps: int) -> Array:
    rng = np.random.default_rng(4)
    out = np.empty((steps, 3))
    for step in range(steps):
        draw(estimate, step, rng.standard_normal(12))
        out[step] = estimate.noise[channel]
    return out


def test_without_errors_the_estimate_is_the_truth() -> None:
    estimate = estimator(EstimatorErrors(), TRUTH, 1)
    assert estimate.position == pytest.approx(TRUTH[0:3], abs=0.0)
    assert estimate.velocity == pytest.approx(TRUTH[3:6], abs=0.0)
    assert estimate.attitude == pytest.approx(TRUTH[6:10], abs=0.0)
    assert estimate.rates == pytest.approx(TRUTH[10:13], abs=0.0)


@pytest.mark.parametrize(("rate_hz", "correlation_time_s"), [(1000.0, 0.05), (100.0, 0.05), (250.0, 0.02)])
def test_noise_has_its_standard_deviation_and_correlation(rate_hz: float, correlation_time_s: float) -> None:
    channel = {"noise_m": 0.1, "correlation_time_s": correlation_time_s, "rate_hz": rate_hz}
    estimate = estimator(conditions(position=channel), TRUTH, 1)
    period = round(1000 / rate_hz)
    series = errors(estimate, 0, 100_000)[::period]
    assert series.std(axis=0) == pytest.approx(0.1, rel=0.1)
    lag = max(1, round(correlation_time_s * rate_hz))
    correlation = np.mean(series[:-lag] * series[lag:]) / np.mean(series**2)
    assert correlation == pytest.approx(math.exp(-lag / rate_hz / correlation_time_s), abs=0.06)


def test_white_noise_is_uncorrelated_from_draw_to_draw_and_held_between() -> None:
    estimate = estimator(conditions(rates={"noise_deg_s": 1.0, "rate_hz": 500.0}), TRUTH, 1)
    series = errors(estimate, 3, 20_000)
    assert (series[0::2] == series[1::2]).all()
    drawn = series[::2]
    assert drawn.std(axis=0) == pytest.approx(math.radians(1.0), rel=0.05)
    assert np.mean(drawn[:-1] * drawn[1:]) / np.mean(drawn**2) == pytest.approx(0.0, abs=0.03)


def test_first_error_is_already_in_the_stationary_state() -> None:
    channel = {"noise_m_s": 0.5, "correlation_time_s": 10.0}
    firsts = [estimator(conditions(velocity=channel), TRUTH, seed).noise[1] for seed in range(1000)]
    assert np.std(firsts) == pytest.approx(0.5, rel=0.06)


def test_attitude_error_is_a_rotation_of_the_body() -> None:
    estimate = estimator(EstimatorErrors(), TRUTH, 1)
    estimate.noise[2] = (0.02, 0.0, 0.0)
    compose(estimate, 1, TRUTH)
    assert np.linalg.norm(estimate.attitude) == pytest.approx(1.0, abs=1e-12)
    expected = multiply(TRUTH[6:10], from_rotation_vector(np.array((0.02, 0.0, 0.0))))
    assert estimate.attitude == pytest.approx(expected, abs=1e-12)


@pytest.mark.parametrize("wander_time_s", [0.5, 5.0])
def test_wander_has_its_standard_deviation_on_each_axis_and_its_correlation(wander_time_s: float) -> None:
    channel: dict[str, Any] = {"wander_m": [0.1, 0.2, 0.3], "wander_time_s": wander_time_s}
    estimate = estimator(conditions(position=channel), TRUTH, 1)
    rng = np.random.default_rng(7)
    series = np.empty((200_000, 3))
    for row in series:
        wander(estimate, rng.standard_normal((4, 3)), 0.1)
        row[:] = estimate.wander[0]
    assert series.std(axis=0) == pytest.approx((0.1, 0.2, 0.3), rel=0.1)
    lag = round(wander_time_s / 0.1)
    correlation = np.mean(series[:-lag] * series[lag:], axis=0) / np.mean(series**2, axis=0)
    assert correlation == pytest.approx(math.exp(-1.0), abs=0.06)


def test_estimate_is_of_the_truth_a_delay_ago() -> None:
    estimate = estimator(conditions(velocity={"delay_s": 0.03}), TRUTH, 1)
    for step in range(100):
        moved = TRUTH.copy()
        moved[0:6] += step
        compose(estimate, step, moved)
        assert estimate.position == pytest.approx(TRUTH[0:3] + step, abs=0.0)
        assert estimate.velocity == pytest.approx(TRUTH[3:6] + max(0, step - 30), abs=0.0)


def test_reset_jumps_by_what_it_says() -> None:
    errors = conditions(position={"wander_m": 0.5}, velocity={"wander_m_s": 0.2})
    estimate = estimator(errors, TRUTH, 1)
    before = np.array((estimate.position, estimate.velocity))
    reset(estimate, np.random.default_rng(3))
    compose(estimate, 1, TRUTH)
    assert np.array((estimate.position, estimate.velocity)) - before == pytest.approx(estimate.jump)
    assert (estimate.jump != 0.0).all()
    assert estimate.resets[0] == 1
