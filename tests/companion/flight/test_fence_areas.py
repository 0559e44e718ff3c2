"""Circles and polygons: what is inside, what is nearest, and that no setpoint gets out."""

import math

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from companion.arrays import Vec3
from companion.errors import InputError
from companion.flight.approach import rest_to_rest
from companion.flight.fence import Areas, Circle, Fence, Place, Polygon, keep_inside
from companion.flight.vehicle_fence import Bound, Bounds, VehicleFence
from companion.trajectory.trajectory import Trajectory, quintic_through

HOME = np.array([1.0, -2.0, 0.5])
L_SHAPE = Polygon(corners_m=((-4, -4), (8, -4), (8, 0), (0, 0), (0, 8), (-4, 8)))
SQUARE = Polygon(corners_m=((2, -3), (4, -3), (4, -1), (2, -1)), keep_out=True)
CYLINDER = Circle(radius_m=6.0)
POND = Circle(north_m=-2.0, east_m=3.0, radius_m=1.0, keep_out=True)
PLACES = arrays(np.float64, 2, elements=st.floats(-20.0, 20.0))
POSITIONS = arrays(np.float64, 3, elements=st.floats(-20.0, 20.0))
FENCES = st.builds(
    Fence,
    circles=st.sets(st.sampled_from([CYLINDER, POND])).map(tuple),
    polygons=st.sets(st.sampled_from([L_SHAPE, SQUARE])).map(tuple),
)
INSIDE = np.array([-2.0, -2.0, -2.0])
"""Of all of these."""


@pytest.mark.parametrize(
    ("place", "outside_m"),
    [((-2, -2), -2.0), ((4, 4), 4.0), ((-4, 9), 1.0), ((11, -8), 5.0), ((1, -1), -1.0)],
)
def test_a_polygon_knows_its_inside(place: tuple[float, float], outside_m: float) -> None:
    assert L_SHAPE.outside_m(np.array(place)) == pytest.approx(outside_m)


@pytest.mark.parametrize(("place", "outside_m"), [((-2, 3), -1.0), ((-2, 5), 1.0), ((1, -1), 4.0)])
def test_a_circle_knows_its_inside(place: tuple[float, float], outside_m: float) -> None:
    assert POND.outside_m(np.array(place)) == pytest.approx(outside_m)


@given(PLACES)
@example(np.array([-2.0, 3.0]))
def test_the_border_is_on_the_border_and_as_far_as_it_is_said_to_be(place: Place) -> None:
    for area in (L_SHAPE, POND):
        border = area.border(place)
        assert max(abs(area.outside_m(point)) for point in border) < 1e-9
        nearest_m = float(np.linalg.norm(border - place, axis=1).min())
        assert nearest_m == pytest.approx(abs(area.outside_m(place)), abs=1e-9)


def test_one_area_to_stay_in_is_enough_and_none_to_keep_out_of_is_entered() -> None:
    areas = Areas(circles=(POND, Circle(north_m=12.0, radius_m=2.0)), polygons=(L_SHAPE,))
    assert areas.beyond_m(np.array([12.0, 0.0])) == pytest.approx(-2.0)
    assert areas.beyond_m(np.array([-2.0, -2.0])) < 0.0
    assert areas.beyond_m(np.array([-2.0, 3.0])) == pytest.approx(1.0)
    assert areas.beyond_m(np.array([20.0, 0.0])) == pytest.approx(6.0)
    assert Areas().beyond_m(np.zeros(2)) == -math.inf


def test_an_ardupilot_must_be_in_all_of_them() -> None:
    areas = Areas(circles=(CYLINDER, Circle(north_m=8.0, radius_m=4.0)), in_all=True)
    assert areas.beyond_m(np.array([5.0, 0.0])) == pytest.approx(-1.0)
    assert areas.beyond_m(np.array([0.0, 0.0])) == pytest.approx(4.0)


def test_where_two_borders_meet_the_setpoint_before_stays() -> None:
    fence, own = Fence(circles=(Circle(radius_m=3.0),)), Areas(circles=(Circle(north_m=5.0, radius_m=3.0),))
    last = HOME + np.array([2.5, 0.0, -2.0])
    inside = keep_inside(HOME + np.array([2.5, 10.0, -3.0]), HOME, fence, own, last)
    np.testing.assert_allclose(inside, HOME + np.array([2.5, 0.0, -3.0]))


@given(POSITIONS, FENCES, FENCES, POSITIONS)
def test_no_setpoint_gets_out(position: Vec3, fence: Fence, vehicles: Fence, last: Vec3) -> None:
    own = Areas(circles=vehicles.circles, polygons=vehicles.polygons)
    was = keep_inside(last, HOME, fence, own, HOME + INSIDE)
    inside = keep_inside(position, HOME, fence, own, was)
    place = inside[:2] - HOME[:2]
    assert fence.beyond_m(place) <= 1e-6
    assert own.beyond_m(place) <= 1e-6
    low, high = fence.corners()
    assert (inside >= HOME + low).all()
    assert (inside <= HOME + high).all()


@given(arrays(np.float64, 2, elements=st.floats(-6.0, 6.0)), FENCES)
def test_what_is_inside_stays_as_it_is(place: Place, fence: Fence) -> None:
    position = HOME + np.array([*place, -2.0])
    kept = keep_inside(position, HOME, fence, Areas(), HOME)
    is_inside = fence.beyond_m(position[:2] - HOME[:2]) <= 0.0
    assert np.array_equal(kept, position) or not is_inside


def test_a_setpoint_beyond_a_polygon_slides_along_its_edge() -> None:
    fence = Fence(polygons=(L_SHAPE,))
    inside = keep_inside(HOME + np.array([5.0, 1.0, -2.0]), HOME, fence, Areas(), HOME)
    np.testing.assert_allclose(inside, HOME + np.array([5.0, 0.0, -2.0]))


@pytest.mark.parametrize(
    "areas", [Areas(circles=(Circle(radius_m=3.0),)), Areas(polygons=(SQUARE,))], ids=["cylinder", "polygon"]
)
def test_a_trajectory_that_leaves_is_refused(areas: Areas) -> None:
    way = rest_to_rest(np.array([0.0, -2.0, -2.0]), np.array([4.0, -2.0, -2.0]), "way")
    with pytest.raises(InputError, match=r"way is 1\.\d+ m beyond the vehicle's fence, \d"):
        areas.require_inside(way, "the vehicle's fence")
    with pytest.raises(InputError, match="beyond the guard's fence"):
        Fence(circles=areas.circles, polygons=areas.polygons).require_inside(way)
    Areas(circles=(Circle(radius_m=5.0),)).require_inside(way, "the vehicle's fence")


def outwards() -> Trajectory:
    """Begins at rest, and ends 1 m north at 10 m/s: between two looks it flies 0.2 m."""
    north = np.array((1.0, 0.0, 0.0))
    ends = [
        np.outer(end, north) + offset for end, offset in (((0, 1), (0, 0, -2)), ((0, 10), 0), ((0, 0), 0))
    ]
    return quintic_through("outwards", 0.219, *ends)


@pytest.mark.parametrize(
    "fence",
    [
        Areas(circles=(Circle(radius_m=0.95),)),
        Fence(north_m=(-5.0, 0.95)),
        VehicleFence(bounds=Bounds(distance=Bound(parameter="FENCE_RADIUS", value_m=0.95, margin_m=0.0))),
    ],
    ids=["areas", "box", "bounds"],
)
def test_a_trajectory_is_looked_at_to_its_end(fence: Areas) -> None:
    with pytest.raises(InputError, match=r"0\.05 m"):
        fence.require_inside(outwards(), "the fence")
