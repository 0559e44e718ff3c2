import numpy as np
import pytest

from companion.arrays import Vec3
from companion.flight.approach import joining, rest_to_rest

LINE = rest_to_rest(np.array([0.0, 0.0, -2.0]), np.array([6.0, 0.0, -2.0]))


@pytest.mark.parametrize(
    "position",
    [np.array([3.0, 0.0, -2.0]), np.array([3.0, 1.5, -2.5]), np.array([-1.0, 0.0, -2.0])],
    ids=["on it", "beside it", "before it"],
)
def test_the_way_ends_on_the_moving_trajectory(position: Vec3) -> None:
    way, joins_s = joining(position, LINE)
    times_s = np.linspace(0.0, way.duration_s, 200)
    begin, end = way.sample(np.array([0.0, way.duration_s - 1e-9])).position
    np.testing.assert_allclose(begin, position, atol=1e-9)
    np.testing.assert_allclose(end, LINE.at(joins_s).position, atol=1e-6)
    moved = way.sample(times_s[:-1])
    np.testing.assert_allclose(moved.velocity[0], np.zeros(3), atol=1e-9)
    np.testing.assert_allclose(moved.velocity[-1], LINE.at(joins_s).velocity, atol=0.05)
    assert np.linalg.norm(moved.velocity, axis=1).max() < 2.0


def test_a_vehicle_at_the_end_is_not_sent_back() -> None:
    way, joins_s = joining(np.array([6.0, 0.0, -2.0]), LINE)
    assert joins_s == LINE.duration_s
    assert np.ptp(way.sample(np.linspace(0.0, way.duration_s, 50)).position[:, 0]) < 1e-6


def test_the_nearest_point_is_where_it_goes_on() -> None:
    _, joins_s = joining(np.array([3.0, 0.0, -2.0]), LINE)
    middle_s = 0.5 * LINE.duration_s
    assert middle_s < joins_s < middle_s + 1.1
