import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from companion.arrays import Times, Vec3s
from companion.trajectory.trajectory import Trajectory, trajectory_of


def helix(times: Times) -> tuple[Vec3s, Vec3s, Vec3s]:
    sine, cosine, one = np.sin(times), np.cos(times), np.ones_like(times)
    return (
        np.stack([sine, cosine, times], axis=1),
        np.stack([cosine, -sine, one], axis=1),
        np.stack([-sine, -cosine, 0.0 * one], axis=1),
    )


@pytest.fixture(scope="module")
def trajectory() -> Trajectory:
    return trajectory_of("helix", 7.3, helix)


def test_follows_the_function_that_it_was_made_of(trajectory: Trajectory) -> None:
    times = np.linspace(0.0, 7.3, 1001)[1:-1]
    for part, expected in zip(trajectory.sample(times), helix(times), strict=True):
        np.testing.assert_allclose(part, expected, atol=1e-6)
    assert trajectory.duration_s == pytest.approx(7.3)


@given(st.floats(min_value=-3.0, max_value=10.0))
def test_one_instant_equals_the_series(time_s: float) -> None:
    trajectory = trajectory_of("helix", 7.3, helix)
    one, series = trajectory.at(time_s), trajectory.sample(np.array([time_s]))
    for part, parts in zip(one, series, strict=True):
        np.testing.assert_allclose(part, parts[0], atol=1e-12)


@pytest.mark.parametrize(("time_s", "end"), [(-1.0, 0.0), (0.0, 0.0), (7.3, 7.3), (99.0, 7.3)])
def test_rests_at_its_ends(trajectory: Trajectory, time_s: float, end: float) -> None:
    sample = trajectory.at(time_s)
    np.testing.assert_allclose(sample.position, helix(np.array([end]))[0][0], atol=1e-12)
    assert not sample.velocity.any()
    assert not sample.acceleration.any()


def test_samples_at_rest_cannot_be_changed_for_others(trajectory: Trajectory) -> None:
    with pytest.raises(ValueError, match="read-only"):
        trajectory.at(-1.0).position[0] = 5.0


def test_not_a_time_is_refused(trajectory: Trajectory) -> None:
    with pytest.raises(ValueError, match="NaN"):
        trajectory.at(float("nan"))


def test_stretching_keeps_the_path_and_divides_velocity_and_acceleration(trajectory: Trajectory) -> None:
    times = np.linspace(0.1, 7.2, 50)
    stretched, original = trajectory.stretched(2.0).sample(2.0 * times), trajectory.sample(times)
    np.testing.assert_allclose(stretched.position, original.position, atol=1e-12)
    np.testing.assert_allclose(stretched.velocity, original.velocity / 2.0, atol=1e-12)
    np.testing.assert_allclose(stretched.acceleration, original.acceleration / 4.0, atol=1e-11)
