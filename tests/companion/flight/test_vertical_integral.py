"""The offset that is held against a load."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from companion.flight.vertical_integral import VerticalIntegral

STEP_S = 0.02
ERRORS = st.floats(-2.0, 2.0)


def test_a_held_error_raises_the_reference_to_a_part_of_it() -> None:
    vertical = VerticalIntegral(rate_1_s=1.0, farthest_m=0.4)
    for _ in range(1000):
        vertical.add(-0.02, alpha=8.0, duration_s=STEP_S)
    assert math.isclose(vertical.offset_m, 8.0 * 1.0 / 0.5 * -0.02, rel_tol=1e-4)


def test_it_is_forgotten_when_the_autopilot_carries_the_load_itself() -> None:
    vertical = VerticalIntegral(rate_1_s=1.0, farthest_m=0.4)
    for _ in range(100):
        vertical.add(-0.02, alpha=8.0, duration_s=STEP_S)
    held_m = vertical.offset_m
    for _ in range(50):
        vertical.add(0.0, alpha=8.0, duration_s=STEP_S)
    assert math.isclose(vertical.offset_m, held_m * math.exp(-0.5), rel_tol=0.01)


@given(st.lists(ERRORS, max_size=200), st.floats(0.0, 100.0))
def test_it_stays_within_bounds_and_comes_back_from_them_at_once(errors_m: list[float], alpha: float) -> None:
    vertical = VerticalIntegral(rate_1_s=1.0, farthest_m=0.4)
    for error_m in errors_m:
        assert abs(vertical.add(error_m, alpha, STEP_S)) <= 0.4
    low_m = vertical.offset_m
    assert vertical.add(0.1, alpha, STEP_S) > low_m or alpha < 1e-3 or low_m == 0.4


@pytest.mark.parametrize("error_m", [math.nan, math.inf, 0.5, -3.0])
def test_a_vehicle_at_its_limits_is_asked_for_no_more(error_m: float) -> None:
    vertical = VerticalIntegral(rate_1_s=1.0, farthest_m=0.4)
    before_m = vertical.add(0.1, alpha=8.0, duration_s=STEP_S)
    assert vertical.add(error_m, alpha=8.0, duration_s=STEP_S) == pytest.approx(0.99 * before_m)


def test_nothing_is_integrated_at_no_rate() -> None:
    assert VerticalIntegral(rate_1_s=0.0, farthest_m=0.4).add(0.1, alpha=8.0, duration_s=1.0) == 0.0
