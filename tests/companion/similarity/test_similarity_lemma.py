"""S, Lemma 1 and the exact loop, on the paper's example and on random systems."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.testing import assert_allclose

from companion.errors import InputError
from companion.experiments.linear.experiment import SOURCE, TARGET
from companion.similarity.lemma import PredictionError, lemma_1, state_response
from companion.similarity.linear_system import Gains, LinearSystem
from companion.similarity.measure import similarity
from companion.similarity.transfer_loop import largest_stable_gain, loop_matrix, spectral_radius

poles = st.lists(st.floats(-0.9, 0.9), min_size=3, max_size=3)
numbers = st.lists(st.floats(-2.0, 2.0), min_size=3, max_size=3).map(np.array)


def system(roots: list[float]) -> LinearSystem:
    A = np.diag(np.ones(2), 1)
    A[2] = -np.poly(roots)[:0:-1]
    return LinearSystem(A, np.array([0.0, 0.0, 1.0]), np.array([0.0, 0.2, 1.0]))


def test_paper_example() -> None:
    s = similarity(SOURCE.gains, TARGET.gains)
    assert abs(s.S1) < 1e-12
    assert_allclose(s.S2, [-0.09, 0.30], atol=1e-12)
    lemma = lemma_1(SOURCE.gains, TARGET.gains, state_response(TARGET))
    assert round(lemma.response.L1, 1) == 5.9
    assert lemma.inverse_state_gain == pytest.approx(0.62, abs=0.005)
    assert lemma.vacuous
    assert not lemma.holds(0.0)
    assert lemma.largest_gain == 0.0
    assert lemma.state_bound(0.0, desired=1.0) == np.inf


def test_paper_example_is_stable_where_the_lemma_is_vacuous() -> None:
    assert spectral_radius(loop_matrix(SOURCE.gains, TARGET, TARGET.gains, 0.0)) < 1.0
    exact = 1.0 / TARGET.input_gain
    assert largest_stable_gain(SOURCE.gains, TARGET, TARGET.gains) > exact
    # With α* = 1/ℬ_t the loop is the target's own exact inverse: poles at its zero and at 0.
    inverted = loop_matrix(SOURCE.gains, TARGET, TARGET.gains, exact)
    assert_allclose(np.sort(np.abs(np.linalg.eigvals(inverted))), [0.0, 0.1], atol=1e-7)


@given(roots=poles, seed=st.integers(0, 1000))
def test_no_input_drives_the_state_beyond_l1_and_l2(roots: list[float], seed: int) -> None:
    target = system(roots)
    response = state_response(target)
    rng = np.random.default_rng(seed)
    state = start = rng.normal(size=3)
    for reference in rng.choice((-1.0, 1.0), size=60):
        state = target.step(state, reference)
        assert np.linalg.norm(state) <= response.L1 + response.L2 * np.linalg.norm(start) + 1e-9


@given(roots=poles, state_gain=numbers, alpha=st.floats(-3.0, 3.0), seed=st.integers(0, 1000))
def test_where_the_lemma_holds_the_state_keeps_its_bound(
    roots: list[float], state_gain: np.ndarray[tuple[int], np.dtype[np.float64]], alpha: float, seed: int
) -> None:
    target, source = system(roots), Gains(0.1 * state_gain, 1.3)
    prediction = PredictionError(0.01, 0.02, 0.03)
    lemma = lemma_1(source, target.gains, state_response(target), prediction)
    assert lemma.holds(alpha) == (abs(alpha) < lemma.largest_gain)
    if not lemma.holds(alpha):
        return
    assert spectral_radius(loop_matrix(source, target, target.gains, alpha)) < 1.0
    rng = np.random.default_rng(seed)
    state = start = rng.normal(size=3)
    bound = lemma.state_bound(alpha, desired=1.0, initial_state=float(np.linalg.norm(start)))
    for desired in rng.choice((-1.0, 1.0), size=40):
        u1 = (desired - source.state @ state) / source.input
        error = desired - target.state_gain @ state - target.input_gain * u1
        error -= rng.uniform(-1.0, 1.0) * (0.01 + 0.02 * np.linalg.norm(state) + 0.03)
        state = target.step(state, u1 + alpha * error)
        assert np.linalg.norm(state) <= bound


def test_identical_systems_are_similar_and_leave_the_gain_free() -> None:
    slow = Gains(0.01 * TARGET.state_gain, TARGET.input_gain)
    lemma = lemma_1(slow, slow, state_response(TARGET))
    assert (lemma.S1_size, lemma.S2_norm) == (0.0, 0.0)
    assert lemma.largest_gain == np.inf


def test_an_unstable_target_is_refused() -> None:
    with pytest.raises(InputError, match="A1"):
        state_response(system([0.5, 0.2, 1.0]))


@given(gain=st.floats(0.01, 10.0), state=numbers, scale=numbers)
def test_s_is_zero_for_the_same_system_and_scales_with_the_state(
    gain: float,
    state: np.ndarray[tuple[int], np.dtype[np.float64]],
    scale: np.ndarray[tuple[int], np.dtype[np.float64]],
) -> None:
    one, other = Gains(state, gain), Gains(scale, 1.3)
    assert similarity(one, one).S1 == 0.0
    assert similarity(one, one).S2_norm == 0.0
    s = similarity(other, one)
    scaled = similarity(Gains(2.0 * scale, 1.3), Gains(2.0 * state, gain))
    assert scaled.S1 == s.S1
    assert_allclose(scaled.S2, 2.0 * s.S2, atol=1e-12)
