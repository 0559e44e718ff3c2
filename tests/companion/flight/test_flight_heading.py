import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from companion.flight.heading import YawMode, turned

FASTEST_RAD_S = math.radians(45.0)
PERIOD_S = 0.02
speeds = st.floats(-5.0, 5.0)


@given(st.floats(-math.pi, math.pi), speeds, speeds, speeds)
def test_the_nose_turns_no_faster_than_it_may(yaw: float, north: float, east: float, down: float) -> None:
    new = turned(yaw, np.array([north, east, down]), PERIOD_S)
    assert abs(math.remainder(new - yaw, math.tau)) <= FASTEST_RAD_S * PERIOD_S + 1e-12
    assert -math.pi <= new <= math.pi


@pytest.mark.parametrize("velocity", [(0.0, 0.0, 0.0), (0.05, -0.05, 0.0), (0.0, 0.0, -3.0)])
def test_at_a_standstill_and_straight_up_the_nose_stays(velocity: tuple[float, float, float]) -> None:
    assert turned(1.0, np.array(velocity), PERIOD_S) == 1.0


@pytest.mark.parametrize(("start", "direction"), [(0.0, 2.0), (3.0, -3.0), (-3.0, 2.5)])
def test_in_motion_the_nose_comes_to_point_along_the_path(start: float, direction: float) -> None:
    heading = YawMode.PATH.heading(start, PERIOD_S)
    velocity = np.array([math.cos(direction), math.sin(direction), 0.0])
    yaws = np.array([heading(velocity) for _ in range(500)])
    assert yaws[-1] == pytest.approx(direction, abs=0.01)
    turned_by = np.abs(np.diff(np.unwrap(yaws))).sum()
    assert turned_by < abs(math.remainder(direction - start, math.tau)) + 0.01  # the shorter way


def test_a_held_heading_is_held() -> None:
    heading = YawMode.HOLD.heading(0.5, PERIOD_S)
    assert [heading(np.array([1.0, 1.0, 0.0])) for _ in range(3)] == [0.5] * 3
