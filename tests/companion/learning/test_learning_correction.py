import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from companion.arrays import Vec3
from companion.learning.correction import (
    Confidence,
    ConstantGain,
    EstimatedGain,
    StiffnessGain,
    adaptation_gain,
    certain_share,
    estimated_gain,
    velocity_correction,
)
from companion.learning.gaussian_process import Kernel
from companion.learning.online_settings import DEFAULT, ESTIMATED, PAPER, OnlineSettings

vectors = arrays(float, 3, elements=st.floats(-1e150, 1e150) | st.sampled_from([np.nan, np.inf, -np.inf]))


KNOWN = np.zeros(3)


@given(vectors, vectors.map(np.abs))
def test_an_estimated_gain_stays_within_its_bounds(gradient: Vec3, variance: Vec3) -> None:
    alpha = estimated_gain(gradient, variance, 0.5, 4.0)
    assert ((alpha >= 0.5) & (alpha <= 4.0)).all()


def test_a_clear_gradient_is_inverted() -> None:
    np.testing.assert_allclose(
        estimated_gain(np.array([-0.5, -1.0, -0.8]), KNOWN, 0.1, 10.0), [2.0, 1.0, 1.25], rtol=1e-9
    )


@given(st.floats(-2.0, 2.0), st.floats(0.0, 4.0), st.floats(0.0, 4.0))
def test_uncertainty_only_lowers_an_estimated_gain(slope: float, variance: float, more: float) -> None:
    gradient = np.full(3, slope)
    surer = estimated_gain(gradient, np.full(3, variance), 0.1, 10.0)
    assert (estimated_gain(gradient, np.full(3, variance + more), 0.1, 10.0) <= surer).all()


def test_a_gradient_as_uncertain_as_it_is_large_halves_the_gain() -> None:
    np.testing.assert_allclose(estimated_gain(np.full(3, -0.5), np.full(3, 0.25), 0.1, 10.0), np.ones(3))


def test_a_gradient_of_the_wrong_sign_or_none_is_answered_cautiously() -> None:
    gradient = np.array([0.5, 0.0, np.nan])
    np.testing.assert_array_equal(estimated_gain(gradient, KNOWN, 0.5, 4.0), [0.5, 0.5, 0.5])


def test_a_gradient_of_unknown_uncertainty_is_answered_cautiously() -> None:
    variance = np.array([np.nan, np.inf, 0.0])
    np.testing.assert_allclose(estimated_gain(np.full(3, -0.5), variance, 0.5, 4.0), [0.5, 0.5, 2.0])


def test_the_kind_of_gain_decides() -> None:
    gradient, stiffness = np.diag([-0.5, -0.5, -0.5]), np.array([2.0, 4.0, 0.1])
    constant = adaptation_gain(ConstantGain(alpha=(5.0, 5.0, 0.5)), gradient, KNOWN, stiffness)
    np.testing.assert_array_equal(constant, [5.0, 5.0, 0.5])
    estimated = adaptation_gain(EstimatedGain(), gradient, KNOWN, stiffness)
    np.testing.assert_allclose(estimated, [2.0, 2.0, 2.0])
    pulling_alike = adaptation_gain(StiffnessGain(stiffness_1_s2=20.0, most=15.0), gradient, KNOWN, stiffness)
    np.testing.assert_allclose(pulling_alike, [10.0, 5.0, 15.0])


def test_confidence_is_nothing_at_first_and_full_where_predictions_come_true() -> None:
    confidence = Confidence(caution=10.0, memory=50)
    assert confidence.share == 0.0
    for _ in range(500):
        confidence.expect(np.array([0.1, 0.0, 0.0]))
        confidence.compare(np.array([1e-4, 0.0, 0.0]))
    assert confidence.share > 0.99


def test_confidence_is_small_where_predictions_are_noise() -> None:
    confidence = Confidence(caution=10.0, memory=50)
    for _ in range(500):
        confidence.expect(np.array([0.01, 0.0, 0.0]))
        confidence.compare(np.array([0.0, 0.01, 0.0]))
    assert confidence.share == pytest.approx(1.0 / 11.0, rel=0.01)


@given(st.lists(st.tuples(vectors, vectors), max_size=20), st.sampled_from([1, 5]))
@example([(np.zeros(3), np.zeros(3))], 1)
def test_confidence_is_a_share_whatever_comes(steps: list[tuple[Vec3, Vec3]], memory: int) -> None:
    confidence = Confidence(caution=10.0, memory=memory)
    with np.errstate(all="ignore"):
        for error, innovation in steps:
            confidence.expect(error)
            confidence.compare(innovation)
            assert 0.0 <= confidence.share <= 1.0


def test_without_caution_confidence_is_full() -> None:
    assert Confidence(caution=0.0, memory=5).share == 1.0


@given(vectors, st.floats(0.0, 1e9), st.floats(0.0, 1e3))
def test_what_is_certain_of_an_error_is_a_share(error: Vec3, variance: float, caution: float) -> None:
    with np.errstate(all="ignore"):
        assert 0.0 <= certain_share(error, variance, caution) <= 1.0


def test_an_error_of_one_deviation_is_half_certain() -> None:
    assert certain_share(np.array([0.0, 0.2, 0.0]), 0.04, 1.0) == pytest.approx(0.5)
    assert certain_share(np.zeros(3), 0.04, 1.0) == 0.0
    assert certain_share(np.zeros(3), 0.04, 0.0) == 1.0


def test_the_velocity_follows_by_finite_difference() -> None:
    moved = velocity_correction(np.array([0.2, 0.0, 0.0]), np.array([0.1, 0.0, 0.0]), 0.5)
    np.testing.assert_allclose(moved, [0.2, 0.0, 0.0])


def test_the_papers_settings() -> None:
    assert PAPER.window == 40
    assert PAPER.kernel == Kernel(prior_variance=1.0, length_scale=20.0, noise_variance=2e-5)
    assert PAPER.gain == ConstantGain(alpha=(5.0, 5.0, 0.5))
    assert PAPER.preview.position_s == pytest.approx((4 / 7, 4 / 7, 3 / 7))


@pytest.mark.parametrize("settings", [PAPER, DEFAULT, ESTIMATED])
def test_settings_survive_a_file(settings: OnlineSettings) -> None:
    assert OnlineSettings.model_validate_json(settings.model_dump_json()) == settings
