"""How far an estimate is from GPS, by the two messages that tell."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from companion.link.dialect import mavlink
from companion.link.gps import GpsComparison

LATITUDE_DEG = 47.0
_M_PER_DEGREE = math.radians(1.0) * 6_371_000.0


def degrees(north_m: float, east_m: float) -> tuple[int, int]:
    latitude = LATITUDE_DEG + north_m / _M_PER_DEGREE
    longitude = 8.0 + east_m / _M_PER_DEGREE / math.cos(math.radians(LATITUDE_DEG))
    return round(latitude * 1e7), round(longitude * 1e7)


def estimate(north_m: float = 0.0, velocity_m_s: float = 0.0) -> mavlink.MAVLink_global_position_int_message:
    speed = round(100 * velocity_m_s)
    return mavlink.MAVLink_global_position_int_message(0, *degrees(north_m, 0.0), 0, 0, speed, 0, 0, 0)


def fix(
    north_m: float, east_m: float = 0.0, *, accuracy_m: float = 0.9, kind: int = mavlink.GPS_FIX_TYPE_3D_FIX
) -> mavlink.MAVLink_gps_raw_int_message:
    place = degrees(north_m, east_m)
    return mavlink.MAVLink_gps_raw_int_message(
        0, kind, *place, 0, 80, 90, 0, 0, 12, h_acc=round(accuracy_m * 1e3)
    )


@given(st.floats(-50.0, 50.0), st.floats(-50.0, 50.0), st.floats(0.0, 20.0))
def test_it_is_the_distance_by_the_accuracy_that_is_claimed(
    north_m: float, east_m: float, accuracy_m: float
) -> None:
    comparison = GpsComparison()
    comparison.estimate(estimate(), 0.0)
    apart_m = comparison.fix(fix(north_m, east_m, accuracy_m=accuracy_m), 0.0)
    assert apart_m == pytest.approx(math.hypot(north_m, east_m) / max(1.0, accuracy_m), rel=0.01, abs=0.02)


def test_one_bad_fix_counts_for_its_share_of_a_second() -> None:
    comparison = GpsComparison()
    for tenth in range(10):
        comparison.estimate(estimate(), 0.1 * tenth)
        assert comparison.fix(fix(0.0), 0.1 * tenth) < 0.02
    assert comparison.fix(fix(5.0), 0.95) == pytest.approx(5.0 / 11, abs=0.02)
    comparison.estimate(estimate(), 2.0)
    assert comparison.fix(fix(5.0), 2.5) == pytest.approx(5.0, abs=0.02)


def test_a_vehicle_in_motion_is_where_it_has_got_to_and_its_fix_may_lag() -> None:
    comparison = GpsComparison()
    comparison.estimate(estimate(velocity_m_s=10.0), 0.0)
    assert comparison.fix(fix(5.0), 0.5) < 0.02
    assert GpsComparison().fix(fix(5.0), 0.5) is math.nan
    late = GpsComparison()
    late.estimate(estimate(velocity_m_s=10.0), 0.0)
    assert late.fix(fix(2.0), 0.5) < 0.02
    assert late.fix(fix(-7.0), 0.5) > 3.0


@pytest.mark.parametrize("kind", [mavlink.GPS_FIX_TYPE_NO_FIX, mavlink.GPS_FIX_TYPE_2D_FIX])
def test_without_a_fix_or_a_fresh_estimate_nothing_is_known(kind: int) -> None:
    comparison = GpsComparison()
    comparison.estimate(estimate(), 0.0)
    assert math.isnan(comparison.fix(fix(9.0, kind=kind), 0.1))
    assert comparison.fix(fix(9.0), 0.2) > 8.0
    assert math.isnan(comparison.fix(fix(9.0), 1.3))
