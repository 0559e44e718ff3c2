"""Harm of what was learned: measured, faded out, and faded in again."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from companion.arrays import Array, Vec3
from companion.learning.negative_transfer import (
    CorrectionJudge,
    Displacement,
    NetworkJudge,
    bounded,
    faded,
    loop_gain,
)
from companion.learning.selection import Selection

STEP_S = 0.02
NOTHING: Vec3 = np.zeros(3)
STIFFNESS, DAMPING = np.full(3, 2.0), np.full(3, 3.0)
vectors = arrays(float, 3, elements=st.floats(-10.0, 10.0))
shares = arrays(float, 2, elements=st.floats(0.0, 1.0))


def wave(k: int) -> Vec3:
    """A displacement (m) that comes and goes."""
    return 0.05 * np.array((np.sin(0.05 * k), 0.0, np.cos(0.03 * k)))


def judged_network(best_share: float, noise_m: float = 0.0, seconds: float = 10.0) -> NetworkJudge:
    """A network whose displacement, times `best_share`, is the error of the plain reference."""
    judge = NetworkJudge(1, 0.3, 3.0)
    rng = np.random.default_rng(0)
    for k in range(round(seconds / STEP_S)):
        would_move = wave(k)
        moved = judge.shares[0] * would_move
        error = best_share * would_move - moved + noise_m * rng.standard_normal(3)
        judge.judge(error, moved, would_move[None, :], STEP_S)
    return judge


@given(vectors)
def test_a_pull_that_is_held_moves_the_vehicle_as_far_as_its_loop_lets_it(pull: Vec3) -> None:
    displacement = Displacement()
    for _ in range(2000):
        displacement.pull(pull, STIFFNESS, DAMPING, STEP_S)
    np.testing.assert_allclose(displacement.position, pull / STIFFNESS, atol=1e-6)


@given(st.floats(0.0, 1e4), st.floats(0.0, 1e3), st.floats(0.0, 1.0))
def test_a_displacement_stays_finite_whatever_the_loop(
    stiffness: float, damping: float, duration_s: float
) -> None:
    displacement = Displacement()
    for _ in range(100):
        displacement.pull(np.ones(3), np.full(3, stiffness), np.full(3, damping), duration_s)
    assert (np.abs(displacement.position) <= 0.5 * (100.0 * duration_s + 1.0) ** 2).all()


@given(shares, shares, st.floats(0.0, 2.0))
def test_shares_stay_shares(share: Array, target: Array, duration_s: float) -> None:
    after = faded(share, 3.0 * target - 1.0, duration_s)
    assert ((after >= 0.0) & (after <= 1.0)).all()


@given(shares, shares)
def test_a_fade_takes_no_longer_than_a_second(share: Array, target: Array) -> None:
    for _ in range(round(1.0 / STEP_S)):
        share = faded(share, target, STEP_S)
    np.testing.assert_allclose(share, target)


@given(st.lists(st.tuples(vectors, vectors, vectors), min_size=1, max_size=60))
def test_whatever_comes_a_network_has_a_share(steps: list[tuple[Vec3, Vec3, Vec3]]) -> None:
    judge = NetworkJudge(1, 0.3, 3.0)
    for error, moved, would_move in steps:
        before = judge.shares[0]
        judge.judge(error, moved, would_move[None, :], STEP_S)
        assert 0.0 <= judge.shares[0] <= 1.0
        assert abs(judge.shares[0] - before) <= STEP_S / 0.5 + 1e-12


@pytest.mark.parametrize("best_share", [0.0, 0.2, 0.5, 0.8, 1.0])
def test_the_share_becomes_the_one_that_leaves_the_least_error(best_share: float) -> None:
    assert judged_network(best_share).shares[0] == pytest.approx(best_share, abs=0.05)


def test_a_network_that_does_harm_is_gone_in_a_few_seconds() -> None:
    assert judged_network(-1.0, seconds=3.0).shares[0] == 0.0


def test_one_look_at_a_network_is_not_all() -> None:
    judge = NetworkJudge(1, 0.3, 3.0)
    would_move = 0.05 * wave(1)
    judge.judge(-would_move, NOTHING, would_move[None, :], STEP_S)
    assert judge.shares[0] == pytest.approx(0.3, abs=0.01)


def test_what_drowns_in_noise_changes_nothing() -> None:
    assert judged_network(-1.0, noise_m=1.0).shares[0] == pytest.approx(0.3, abs=0.1)


def test_without_a_memory_nobody_judges() -> None:
    judge = NetworkJudge(1, 0.3, 0.0)
    for k in range(500):
        judge.judge(-wave(k), NOTHING, wave(k)[None, :], STEP_S)
    assert judge.shares[0] == 0.3
    assert judge.gains[0] == 0.0


def error_of(judge: CorrectionJudge, sign: float, k: int) -> tuple[Vec3, Vec3]:
    """Error left (m), and displacement by the correction; `sign` 1 is a model that is right."""
    alone = 4.0 * wave(k)
    moved = 0.9 * sign * judge.share * alone
    return alone - moved, moved


def fly_correction(judge: CorrectionJudge, sign: float, seconds: float) -> None:
    for k in range(round(seconds / STEP_S)):
        error, moved = error_of(judge, sign, k)
        would_move = 0.9 * sign * 4.0 * wave(k)
        judge.judge(error, sign * error, moved, would_move, 0.8, STEP_S)


def test_a_correction_that_helps_is_believed() -> None:
    judge = CorrectionJudge(3.0)
    fly_correction(judge, 1.0, 20.0)
    assert judge.believed
    assert judge.share == 1.0


def test_one_that_goes_the_wrong_way_is_off_within_a_second() -> None:
    judge = CorrectionJudge(3.0)
    fly_correction(judge, -1.0, 1.0)
    assert not judge.believed
    assert judge.share == 0.0
    fly_correction(judge, -1.0, 20.0)
    assert not judge.believed


def test_one_that_would_help_again_comes_back() -> None:
    judge = CorrectionJudge(3.0)
    fly_correction(judge, -1.0, 2.0)
    fly_correction(judge, 1.0, 6.0)
    assert judge.believed
    assert judge.share == 1.0


def test_one_that_makes_errors_larger_by_its_own_model_is_not_believed() -> None:
    judge = CorrectionJudge(3.0)
    for _ in range(100):
        judge.judge(NOTHING, NOTHING, NOTHING, NOTHING, 3.0, STEP_S)
    assert not judge.believed


def test_small_errors_are_no_harm() -> None:
    judge = CorrectionJudge(3.0)
    for k in range(500):
        error = 0.02 * wave(k)
        judge.judge(error, -error, -0.5 * error, error, 1.0, STEP_S)
    assert judge.believed


@given(vectors, st.floats(0.01, 100.0), st.floats(0.001, 10.0))
def test_no_pull_moves_the_vehicle_farther_than_it_may(
    pull: Vec3, stiffness: float, farthest_m: float
) -> None:
    part = bounded(pull, np.full(3, stiffness), farthest_m)
    assert 0.0 <= part <= 1.0
    assert np.linalg.norm(part * pull / stiffness) <= farthest_m * (1.0 + 1e-9)


def test_nothing_is_left_of_a_pull_that_is_not_finite() -> None:
    assert bounded(np.array((1.0, np.nan, 0.0)), STIFFNESS, 0.1) == 0.0


def test_the_loop_gain_is_what_a_correction_leaves_of_an_error() -> None:
    gradient = np.diag((-0.1, -0.5, np.nan))
    np.testing.assert_allclose(loop_gain(np.array((10.0, 5.0, 1.0)), gradient), (0.0, 1.5, 1.0))


def test_one_network_alone_is_followed_from_the_beginning() -> None:
    selection = Selection(1)
    assert selection.chosen == 0
    np.testing.assert_array_equal(selection.weights, (1.0,))


def choose(selection: Selection, gains: Array, seconds: float, *, tells: bool = True) -> None:
    for _ in range(round(seconds / STEP_S)):
        before = selection.weights
        selection.choose(gains, tells=tells, duration_s=STEP_S)
        assert (np.abs(selection.weights - before) <= STEP_S / 0.5 + 1e-12).all()
        assert selection.weights.sum() <= 1.0 + 1e-9


def test_of_several_the_best_is_followed_once_they_have_been_heard() -> None:
    selection, gains = Selection(3), np.array((1e-4, 4e-4, -1e-4))
    choose(selection, gains, 10.0, tells=False)
    choose(selection, gains, 2.0)
    chosen = [selection.chosen]
    choose(selection, gains, 2.0)
    assert [*chosen, selection.chosen] == [None, 1]
    np.testing.assert_allclose(selection.weights, (0.0, 1.0, 0.0))


def test_another_takes_over_only_when_it_is_clearly_better() -> None:
    selection = Selection(2)
    choose(selection, np.array((4e-4, 1e-4)), 4.0)
    choose(selection, np.array((4e-4, 6e-4)), 4.0)
    assert selection.chosen == 0
    choose(selection, np.array((4e-4, 9e-4)), 1.0)
    assert selection.chosen == 1
    np.testing.assert_allclose(selection.weights, (0.0, 1.0))


def test_networks_that_only_do_harm_are_not_followed() -> None:
    selection = Selection(2)
    choose(selection, np.array((-1e-4, 0.0)), 20.0)
    assert selection.chosen is None
