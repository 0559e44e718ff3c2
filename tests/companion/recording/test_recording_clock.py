"""The map from the recording machine's clock to the vehicle's."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from companion.arrays import Times
from companion.recording.clock_map import FRAMES, fit_clock, rising


def drifting(sent_s: Times, rate: float, stall_s: float) -> Times:
    """A vehicle's clock that runs at `rate`, and stands still for `stall_s` from second 10 on."""
    return 3.0 + rate * (sent_s - np.clip(sent_s - 10.0, 0.0, stall_s))


@given(
    rate=st.floats(0.95, 1.05),
    stall_s=st.floats(0.0, 0.3),
    jitter_s=st.floats(0.0, 0.02),
    seed=st.integers(0, 99),
)
def test_a_drifting_clock_is_recovered_under_jitter(
    rate: float, stall_s: float, jitter_s: float, seed: int
) -> None:
    rng = np.random.default_rng(seed)
    sent_s = np.sort(rng.uniform(0.0, 20.0, size=4000))
    received_s = sent_s + rng.exponential(jitter_s, size=4000)
    clock = fit_clock(1.7e9 + received_s, np.round(drifting(sent_s, rate, stall_s), 3))
    asked_s = np.linspace(0.2, 19.8, 500)
    away_from_the_stall = (asked_s < 9.7) | (asked_s > 10.7)
    error_s = clock(1.7e9 + asked_s) - drifting(asked_s, rate, stall_s)
    least_late_s = 0.002 + 0.01 + jitter_s  # rounding, drift within a group, what even the least late lacks
    assert np.abs(error_s[away_from_the_stall]).max() <= least_late_s
    assert np.abs(error_s).max() <= least_late_s + stall_s


@given(st.lists(st.tuples(st.floats(0.0, 100.0), st.floats(0.0, 100.0)), min_size=1, max_size=80))
def test_whatever_the_frames_say_time_never_falls(frames: list[tuple[float, float]]) -> None:
    received_s, vehicle_s = np.array(frames).T
    clock = fit_clock(received_s, vehicle_s)
    mapped_s = clock(np.linspace(-10.0, 110.0, 300))
    assert np.isfinite(mapped_s).all()
    assert (np.diff(mapped_s) >= -1e-9).all()


def test_of_frames_in_a_row_the_least_late_one_counts() -> None:
    sent_s = np.arange(2 * FRAMES) / 100.0
    late_s = np.full(2 * FRAMES, 0.009)
    late_s[[3, FRAMES + 4]] = 0.0
    clock = fit_clock(sent_s + late_s, sent_s)
    np.testing.assert_allclose(clock(np.array([0.1, 0.15, 0.2])), [0.1, 0.15, 0.2], atol=1e-12)


def test_beyond_what_is_known_both_clocks_run_alike() -> None:
    clock = fit_clock(np.array([100.0]), np.array([5.0]))
    assert clock(np.array([98.0, 100.0, 103.0])).tolist() == [3.0, 5.0, 8.0]
    assert clock(np.array([])).shape == (0,)


def test_only_what_is_later_than_all_before_is_rising() -> None:
    assert rising(np.array([1.0, 1.0, 3.0, 2.0, 3.0, 4.0])).tolist() == [0, 2, 5]
    assert rising(np.array([])).tolist() == []
