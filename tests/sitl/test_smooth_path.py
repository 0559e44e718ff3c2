import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from sitl.arrays import Array, Vec3
from sitl.firmware.smooth_path import Path, PathLimits, approach, begin, braking_distance, path_at_rest

LIMITS = PathLimits(horizontal=5.0, up=3.0, down=1.5, acceleration=3.0)
JERK = 4.0
DT = 0.01
coordinate = st.floats(-60.0, 60.0)
targets = st.tuples(coordinate, coordinate, coordinate).map(lambda v: np.array(v))


def new_path() -> Path:
    return path_at_rest(LIMITS.acceleration, JERK, DT)


def walk(target: Vec3, velocity: tuple[float, float, float] = (0.0, 0.0, 0.0)) -> Array:
    """Rows of position, velocity and acceleration until the point has come to rest."""
    path = new_path()
    begin(path, np.zeros(3), np.array(velocity), DT)
    rows = []
    for _ in range(6_000):
        approach(path, target, LIMITS, DT)
        rows.append(np.concatenate((path.position, path.velocity, path.acceleration)))
    return np.array(rows)


@settings(max_examples=15)
@given(targets)
def test_arrives_without_overshoot_within_its_limits(target: Vec3) -> None:
    rows = walk(target)
    assert rows[-1, 0:3] == pytest.approx(target, abs=0.01)
    assert (rows[:, 0:3] * np.sign(target) <= np.abs(target) + 1e-4).all()
    assert np.hypot(rows[:, 3], rows[:, 4]).max() <= 5.0 + 1e-9
    assert rows[:, 5].min() >= -3.0 - 1e-9
    assert rows[:, 5].max() <= 1.5 + 1e-9
    assert np.abs(rows[:, 6:9]).max() <= 3.0 + 1e-9
    jerk = np.abs(np.diff(rows[:, 6:9], axis=0)).max() / DT
    assert jerk <= 2.0 * JERK + 1e-9  # twice where braking follows on speeding up without a pause


def test_goes_straight_from_rest() -> None:
    rows = walk(np.array((30.0, 10.0, 0.0)))
    assert rows[:, 1] * 3.0 == pytest.approx(rows[:, 0], abs=1e-6)


def test_brakes_to_about_the_braking_distance() -> None:
    distance = braking_distance(new_path(), 4.0, LIMITS.acceleration, DT)
    rows = walk(np.array((distance, 0.0, 0.0)), velocity=(4.0, 0.0, 0.0))
    assert rows[:, 0].max() < 1.02 * distance
    assert rows[-1, 0] == pytest.approx(distance, abs=0.01)
