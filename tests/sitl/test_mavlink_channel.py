from collections.abc import Sequence

import numpy as np
import pytest

from sitl.mavlink.channel import Channel


def channel(latency_s: float, jitter_s: float, loss: float, seed: int = 1) -> Channel:
    return Channel(latency_s, jitter_s, loss, np.random.default_rng(seed))


def test_an_ideal_channel_is_immediate() -> None:
    ideal = channel(0.0, 0.0, 0.0)
    assert [ideal.arrivals_s(t) for t in (0.0, 1.5)] == [[0.0], [1.5]]


def test_latency_is_uniform_around_its_mean_and_frames_may_overtake() -> None:
    arrivals = channel(0.02, 0.01, 0.0)
    latencies = np.array([arrivals.arrivals_s(5.0) for _ in range(20_000)])[:, 0] - 5.0
    assert latencies.min() >= 0.01
    assert latencies.max() <= 0.03
    assert latencies.mean() == pytest.approx(0.02, abs=2e-4)
    assert latencies.std() == pytest.approx(0.02 / np.sqrt(12.0), rel=0.02)
    assert (np.diff(latencies) < 0.0).any()


def test_the_stated_share_of_frames_is_lost() -> None:
    lossy = channel(0.02, 0.01, 0.01)
    lost = sum(not lossy.arrivals_s(0.0) for _ in range(50_000))
    assert lost / 50_000 == pytest.approx(0.01, abs=0.002)


def test_jitter_larger_than_latency_never_delivers_before_the_frame_was_sent() -> None:
    wild = channel(0.01, 0.05, 0.0)
    assert min(min(wild.arrivals_s(1.0)) for _ in range(1000)) == 1.0


def test_the_stated_share_of_frames_comes_twice_and_behind_later_ones() -> None:
    rng = np.random.default_rng(1)
    disorderly = Channel(0.02, 0.0, 0.0, rng, duplicates=0.02, overtaken=0.02)
    sent = [disorderly.arrivals_s(0.0) for _ in range(50_000)]
    assert sum(len(times) == 2 for times in sent) / 50_000 == pytest.approx(0.02, abs=0.003)
    late = [time_s > 0.02 for times in sent for time_s in times]
    assert np.mean(late) == pytest.approx(0.02, abs=0.003)


def test_the_seed_fixes_every_draw() -> None:
    def draws(seed: int) -> list[Sequence[float]]:
        lossy = channel(0.02, 0.01, 0.1, seed)
        return [lossy.arrivals_s(0.0) for _ in range(2000)]

    assert draws(1) == draws(1)
    assert draws(1) != draws(2)
