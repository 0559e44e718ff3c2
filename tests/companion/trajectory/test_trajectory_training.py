import numpy as np
import pytest

from companion.errors import InputError
from companion.trajectory.limits import Limits, peaks_of, stretches
from companion.trajectory.training import SPEED_M_S, training_sinusoids


@pytest.mark.parametrize("box_m", [(5.0, 5.0, 3.0), (2.0, 3.0, 1.0), (20.0, 20.0, 10.0)])
@pytest.mark.parametrize("speed_m_s", [None, 1.0])
def test_keeps_to_box_time_and_limits(box_m: tuple[float, float, float], speed_m_s: float | None) -> None:
    limits = Limits(speed_m_s=speed_m_s)
    trajectory = training_sinusoids(60.0, box_m, limits)
    assert trajectory.duration_s == pytest.approx(60.0)
    reached = stretches(peaks_of(trajectory), limits.peaks(SPEED_M_S))
    assert max(reached.values()) <= 1.0 + 1e-9
    position = trajectory.sample(np.linspace(0.0, 60.0, 6001)).position
    north, east, up = (0.5 * side + 1e-3 for side in box_m)
    assert np.abs(position[:, 0]).max() <= north
    assert np.abs(position[:, 1]).max() <= east
    assert np.abs(-position[:, 2] - 1.5 - 0.5 * box_m[2]).max() <= up
    fills_the_box = np.isclose(np.ptp(position, axis=0), box_m, rtol=0.01).all()
    assert fills_the_box or max(reached.values()) == pytest.approx(1.0, abs=0.05)


def test_is_rich_on_every_axis() -> None:
    trajectory = training_sinusoids()
    _, velocity, acceleration = trajectory.sample(np.arange(0.0, 400.0, 0.02))
    horizontal = np.linalg.norm(velocity[:, :2], axis=1)
    assert horizontal.max() > 1.5
    assert peaks_of(trajectory).acceleration_m_s2 > 3.0
    assert np.abs(velocity[:, 2]).max() > 0.8
    assert (acceleration.std(axis=0) > 0.4).all()
    assert np.abs(np.corrcoef(velocity.T) - np.eye(3)).max() < 0.2


def test_starts_and_ends_at_rest() -> None:
    trajectory = training_sinusoids(30.0)
    for time_s in (1e-6, 30.0 - 1e-6):
        _, velocity, acceleration = trajectory.at(time_s)
        assert np.abs(velocity).max() < 1e-4
        assert np.abs(acceleration).max() < 1e-3


def test_the_seed_decides() -> None:
    first, again, other = (training_sinusoids(20.0, seed=seed).coefficients for seed in (0, 0, 1))
    assert np.array_equal(first, again)
    assert not np.array_equal(first, other)


@pytest.mark.parametrize("box_m", [(0.0, 1.0, 1.0), (1.0, float("nan"), 1.0)])
def test_a_box_has_sides(box_m: tuple[float, float, float]) -> None:
    with pytest.raises(InputError, match="box"):
        training_sinusoids(box_m=box_m)


def test_a_moment_is_too_short() -> None:
    with pytest.raises(InputError, match="too short"):
        training_sinusoids(duration_s=1.0)
