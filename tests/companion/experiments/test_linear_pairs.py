"""Random pairs of linear systems: how they are drawn, what the guard does, and a slice of the benchmark."""

import json
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from companion.cli import bench_pairs
from companion.experiments.backend import Backend
from companion.experiments.linear import pairs
from companion.experiments.linear.guarded import FADE_STEPS, Guard
from companion.experiments.linear.inverse import ExactInverse
from companion.experiments.linear.pairs import PairRow, fly_pair, summarise
from companion.experiments.linear.random_pairs import canonical_system, draw_pair
from companion.learning.cautious_correction import ErrorBelief

SLICE = 20
KNOWN = ErrorBelief(error=0.5, gain=1.0)


@pytest.fixture(scope="module")
def rows() -> list[PairRow]:
    return [fly_pair(index, seed=0, noise=0.0) for index in range(SLICE)]


@given(st.integers(0, 2**32), st.integers(0, 10**6))
def test_pairs_satisfy_the_assumptions_of_the_paper(seed: int, index: int) -> None:
    pair = draw_pair(seed, index)
    for system in (pair.source, pair.target):
        assert np.all(np.abs(system.poles) < 1.0)
        assert np.all(np.abs(system.zeros) < 1.0)
        assert 0.5 <= system.input_gain <= 2.0
    assert pair.source.relative_degree == pair.target.relative_degree
    assert len(pair.source.B) == len(pair.target.B)


def test_canonical_system_has_the_given_poles_zeros_and_gain() -> None:
    system = canonical_system(np.array([0.5 + 0.2j, 0.5 - 0.2j, -0.3]), np.array([0.4 + 0j]), gain=1.7)
    np.testing.assert_allclose(sorted(system.poles, key=np.imag), [0.5 - 0.2j, -0.3, 0.5 + 0.2j], atol=1e-9)
    np.testing.assert_allclose(system.zeros, [0.4], atol=1e-9)
    assert system.relative_degree == 2
    assert system.input_gain == pytest.approx(1.7)


def test_exact_inverse_takes_its_own_system_to_the_desired_output() -> None:
    system = draw_pair(3, 4).source
    r, state = system.relative_degree, np.linspace(-1.0, 1.0, len(system.B))
    reference = ExactInverse(system)(state, 0.8)
    later = system.step(state, reference)
    for _ in range(r - 1):
        later = system.step(later, 0.0)
    assert system.C @ later == pytest.approx(0.8)


def _weights(guard: Guard, belief: ErrorBelief, *, output: float, plain: float, steps: int) -> list[float]:
    return [guard.weigh(output, belief, plain, desired_output=0.0) for _ in range(steps)]


def test_guard_begins_with_the_plain_reference_and_fades_the_learned_one_in() -> None:
    weights = _weights(Guard(2, window=10), KNOWN, output=0.0, plain=-1.0, steps=FADE_STEPS)
    np.testing.assert_allclose(weights, np.arange(1, FADE_STEPS + 1) / FADE_STEPS)


def test_guard_falls_back_on_measured_harm_and_returns_after_it() -> None:
    guard = Guard(1, window=10)
    _weights(guard, KNOWN, output=0.0, plain=-1.0, steps=2 * FADE_STEPS)
    assert _weights(guard, KNOWN, output=9.0, plain=-1.0, steps=FADE_STEPS)[-1] == 0.0
    assert _weights(guard, KNOWN, output=0.0, plain=-1.0, steps=10 + FADE_STEPS)[-1] == 1.0


def test_guard_falls_back_where_the_loop_gain_is_above_one() -> None:
    guard = Guard(1, window=10)
    _weights(guard, KNOWN, output=0.0, plain=-1.0, steps=2 * FADE_STEPS)
    twice_and_more = ErrorBelief(error=0.5, gain=2.1)
    assert guard.weigh(0.0, twice_and_more, plain=-1.0, desired_output=0.0) < 1.0
    assert guard.weigh(0.0, twice_and_more, plain=-1.0, desired_output=0.0) == 1.0


def test_guard_trusts_nothing_that_is_expected_to_be_worse_than_plain() -> None:
    uncertain = ErrorBelief(0.5, 1.0, error_variance=np.inf)
    assert _weights(Guard(1, window=10), uncertain, output=0.0, plain=-1.0, steps=5) == [0.0] * 5


def test_no_pair_diverges_and_the_median_is_far_below_the_baseline(rows: list[PairRow]) -> None:
    summary = summarise(rows)
    assert summary.pairs == SLICE
    assert summary.diverged == summary.worse_than_baseline == 0
    assert summary.median_ratio <= 0.2
    assert summary.network_diverged_share > 0.1  # or the guard and the correction had nothing to do


def test_lemma_is_never_laxer_than_the_loop(rows: list[PairRow]) -> None:
    bounded = [row for row in rows if row.lemma_alpha_bound > 0.0]
    assert bounded
    for row in bounded:
        assert row.lemma_alpha_bound <= row.largest_stable_alpha
        assert row.lemma_held == (row.alpha < row.lemma_alpha_bound)


def test_same_seed_gives_the_same_row(rows: list[PairRow]) -> None:
    assert fly_pair(7, seed=0, noise=0.0) == rows[7]
    assert fly_pair(7, seed=1, noise=0.0) != rows[7]


def test_command_goes_on_where_it_was_stopped(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(pairs, "LOCAL", Backend("sequential"))
    whole, resumed = tmp_path / "whole.json", tmp_path / "resumed.json"
    bench_pairs.pairs(count=3, noise=0.01, seed=5, json=whole)

    flown: list[int] = []

    def stop_at_the_third(index: int, *, seed: int, noise: float) -> PairRow:
        if len(flown) == 2:
            raise KeyboardInterrupt
        flown.append(index)
        return fly_pair(index, seed=seed, noise=noise)

    with monkeypatch.context() as interrupted:
        interrupted.setattr(pairs, "fly_pair", stop_at_the_third)
        with pytest.raises(KeyboardInterrupt):
            bench_pairs.pairs(count=3, noise=0.01, seed=5, json=resumed)
    bench_pairs.pairs(count=3, noise=0.01, seed=5, json=resumed)
    assert resumed.read_bytes() == whole.read_bytes()
    assert len(json.loads(whole.read_text())["rows"]) == 3
    assert sorted(path.name for path in tmp_path.iterdir()) == ["resumed.json", "whole.json"]
