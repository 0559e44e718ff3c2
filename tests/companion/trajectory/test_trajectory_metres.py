import numpy as np
import pytest

from companion.arrays import Times, Vec3s
from companion.errors import InputError
from companion.trajectory.limits import Limits, peaks_of, stretches
from companion.trajectory.metres import TOLERANCES_M, timed_trajectory
from companion.trajectory.trajectory import Trajectory

CORNER = np.array([[0.0, 0.0, -2.0], [2.0, 0.0, -2.0], [2.0, 2.0, -2.0]])


def circle(times: Times, radius_m: float = 2.0) -> Vec3s:
    return radius_m * np.stack([np.cos(times), np.sin(times), -2.0 + 0.0 * times], axis=1)


def speed_in_the_middle(trajectory: Trajectory) -> float:
    return float(np.linalg.norm(trajectory.at(0.5 * trajectory.duration_s).velocity))


def test_what_the_limits_allow_is_flown_as_given() -> None:
    times = np.linspace(0.0, 12.0, 601)
    trajectory = timed_trajectory("circle", times, circle(0.5 * times), Limits())
    eased_s = 0.5 * (trajectory.duration_s - 12.0)
    assert 0.0 < eased_s < 0.5
    flown = trajectory.sample(times[50:-50] + eased_s)
    np.testing.assert_allclose(flown.position, circle(0.5 * times)[50:-50], atol=TOLERANCES_M[0] + 0.01)
    assert speed_in_the_middle(trajectory) == pytest.approx(1.0, rel=0.01)


def test_a_speed_that_is_asked_for_is_reached() -> None:
    times = np.linspace(0.0, 12.0, 601)
    trajectory = timed_trajectory("circle", times, circle(0.5 * times), Limits(speed_m_s=2.0))
    assert peaks_of(trajectory).speed_m_s == pytest.approx(2.0, rel=0.01)


def test_what_is_too_fast_is_slowed_in_proportion() -> None:
    times = np.linspace(0.0, 6.0, 601)
    limits = Limits()
    trajectory = timed_trajectory("circle", times, circle(2.0 * times), limits)
    assert peaks_of(trajectory).acceleration_m_s2 == pytest.approx(4.0, rel=1e-6)
    assert max(stretches(peaks_of(trajectory), limits.peaks(np.inf)).values()) <= 1.0 + 1e-9


def test_corners_are_rounded_by_no_more_than_the_last_tolerance() -> None:
    trajectory = timed_trajectory("corner", np.array([0.0, 2.0, 4.0]), CORNER, Limits())
    flown = trajectory.sample(np.linspace(0.0, trajectory.duration_s, 5000)).position
    distance = np.linalg.norm(flown - CORNER[1], axis=1).min()
    assert TOLERANCES_M[0] < distance < 2.0 * TOLERANCES_M[-1]


def test_start_and_end_are_those_of_the_file() -> None:
    trajectory = timed_trajectory("corner", np.array([5.0, 15.0, 25.0]), CORNER, Limits())
    np.testing.assert_allclose(trajectory.at(0.0).position, CORNER[0], atol=TOLERANCES_M[-1])
    np.testing.assert_allclose(trajectory.at(99.0).position, CORNER[-1], atol=TOLERANCES_M[-1])


def test_a_vehicle_that_stays_where_it_is_has_no_trajectory() -> None:
    with pytest.raises(InputError, match="all positions are the same"):
        timed_trajectory("point", np.array([0.0, 1.0]), np.ones((2, 3)), Limits())
