import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from companion.flight.heading import YawMode, turned, yaw_jump
from companion.state import VehicleState

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


def state(time_s: float, yaw: float, rate: float, roll: float = 0.0) -> VehicleState:
    rates = np.array([0.0, rate * math.sin(roll), rate * math.cos(roll)])
    return VehicleState(time_s, time_s, np.zeros(3), np.zeros(3), np.array([roll, 0.0, yaw]), rates)


@given(
    yaw=st.floats(-math.pi, math.pi),
    rate=st.floats(-3.0, 3.0),
    elapsed_s=st.floats(0.005, 0.2),
    jump=st.one_of(st.just(0.0), st.floats(0.3, 3.0)),
    roll=st.floats(-0.5, 0.5),
)
def test_a_turn_is_no_jump_and_a_jump_is_none_of_a_turn(
    yaw: float, rate: float, elapsed_s: float, jump: float, roll: float
) -> None:
    after = math.remainder(yaw + rate * elapsed_s + jump, math.tau)
    told = yaw_jump(state(1.0, yaw, rate, roll), state(1.0 + elapsed_s, after, rate, roll))
    assert told == pytest.approx(jump, abs=1e-9)


def test_across_a_long_gap_nothing_jumps() -> None:
    assert yaw_jump(state(1.0, 0.0, 0.0), state(2.5, 2.0, 0.0)) == 0.0


def test_the_nose_stays_where_it_is_when_the_estimate_jumps() -> None:
    for mode in YawMode:
        heading = mode.heading(3.0, 0.02)
        heading.shift(0.5)
        assert heading(np.zeros(3)) == pytest.approx(3.5 - math.tau)
