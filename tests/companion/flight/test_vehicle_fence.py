"""How far a vehicle's parameters let it go, in its fence and in the guard's answer."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from companion.arrays import Vec3
from companion.errors import InputError
from companion.flight.approach import rest_to_rest
from companion.flight.fence import Circle, Fence, keep_inside
from companion.flight.vehicle_fence import NO_FENCE, Bound, Bounds, VehicleFence

HOME = np.array([1.0, -2.0, 0.5])
DISTANCE = Bound(parameter="GF_MAX_HOR_DIST", value_m=10.5, margin_m=0.5)
CEILING = Bound(parameter="GF_MAX_VER_DIST", value_m=6.0, margin_m=0.5)
FLOOR = Bound(parameter="FENCE_ALT_MIN", value_m=1.0, margin_m=0.5)
BOUNDS = Bounds(distance=DISTANCE, ceiling=CEILING, floor=FLOOR)
POND = Circle(north_m=7.0, radius_m=2.0, keep_out=True)
INSIDE = np.array([0.0, 1.0, -2.0])


@given(
    position=arrays(np.float64, 3, elements=st.floats(-40.0, 40.0)),
    distance=st.sampled_from([DISTANCE, None]),
    ceiling=st.sampled_from([CEILING, None]),
    floor=st.sampled_from([FLOOR, None]),
    circles=st.sampled_from([(), (POND,)]),
)
def test_no_setpoint_gets_beyond(
    position: Vec3,
    distance: Bound | None,
    ceiling: Bound | None,
    floor: Bound | None,
    circles: tuple[Circle, ...],
) -> None:
    bounds = Bounds(distance=distance, ceiling=ceiling, floor=floor)
    fence = VehicleFence(circles=circles, bounds=bounds)
    north, east, down = keep_inside(HOME + position, HOME, Fence(), fence, HOME + INSIDE) - HOME
    low_m, high_m = bounds.altitude_m
    assert math.hypot(north, east) <= bounds.distance_m + 1e-6
    assert max(low_m, 0.5) - 1e-9 <= -down <= min(high_m, 50.0) + 1e-9
    assert fence.beyond_m(np.array([north, east])) <= 1e-6


def test_beyond_the_distance_the_nearest_point_is_on_the_way_home() -> None:
    fence = VehicleFence(bounds=BOUNDS)
    kept = keep_inside(HOME + np.array([12.0, 16.0, -9.0]), HOME, Fence(), fence, HOME + INSIDE)
    np.testing.assert_allclose(kept, HOME + np.array([6.0, 8.0, -5.5]))


@pytest.mark.parametrize(
    ("end", "told"),
    [
        ((11.0, 0.0, -2.0), r"way is 1\.00 m beyond what the vehicle's GF_MAX_HOR_DIST 10\.5 allows"),
        ((0.0, -10.2, -2.0), r"way is 0\.20 m beyond what .* kept 0\.5 m away from, \d+\.\d s after"),
        ((0.0, 0.0, -6.5), r"1\.00 m beyond what the vehicle's GF_MAX_VER_DIST 6 allows.*change GF_MAX_VER"),
        ((0.0, 0.0, -1.0), r"0\.50 m beyond what the vehicle's FENCE_ALT_MIN 1 allows"),
    ],
)
def test_a_trajectory_that_leads_farther_is_refused(end: tuple[float, ...], told: str) -> None:
    way = rest_to_rest(np.array([0.0, 0.0, -2.0]), np.array(end), "way")
    with pytest.raises(InputError, match=told):
        VehicleFence(bounds=BOUNDS).require_inside(way)
    NO_FENCE.require_inside(way)


def test_one_that_stays_within_is_flown_unless_it_enters_an_area_to_keep_out_of() -> None:
    way = rest_to_rest(np.array([0.0, 0.0, -1.6]), np.array([9.9, 0.0, -5.4]), "way")
    VehicleFence(bounds=BOUNDS).require_inside(way)
    with pytest.raises(InputError, match=r"way is 2\.00 m beyond the vehicle's fence"):
        VehicleFence(circles=(POND,), bounds=BOUNDS).require_inside(way)


def test_the_bounds_hold_beside_areas_of_which_one_is_enough() -> None:
    fence = VehicleFence(circles=(Circle(north_m=12.0, radius_m=8.0),), bounds=BOUNDS)
    assert fence.beyond_m(np.array([12.0, 0.0])) == pytest.approx(2.0)
    assert fence.beyond_m(np.array([0.0, 0.0])) == pytest.approx(4.0)
    assert fence.beyond_m(np.array([8.0, 0.0])) == pytest.approx(-2.0)


@pytest.mark.parametrize(("asked_m", "flown_m"), [(2.5, 2.5), (1.0, 1.5), (20.0, 5.5)])
def test_a_takeoff_leads_between_floor_and_ceiling(asked_m: float, flown_m: float) -> None:
    assert BOUNDS.altitude_within(asked_m) == flown_m
    assert Bounds().altitude_within(asked_m) == asked_m


def test_it_is_told_by_its_parameters() -> None:
    assert str(BOUNDS) == (
        "within 10 m of the takeoff point (GF_MAX_HOR_DIST 10.5), "
        "at most 5.5 m above it (GF_MAX_VER_DIST 6), at least 1.5 m above it (FENCE_ALT_MIN 1)"
    )
    assert not Bounds()
    assert Bounds(ceiling=CEILING)


def test_it_survives_the_recording() -> None:
    fence = VehicleFence(circles=(POND,), bounds=BOUNDS)
    assert VehicleFence.model_validate_json(fence.model_dump_json()) == fence
    assert VehicleFence.model_validate({"circles": [], "polygons": [], "in_all": True}).bounds == Bounds()
