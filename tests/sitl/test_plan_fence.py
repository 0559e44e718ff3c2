import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from plan_items import item

from sitl.plan.fence import Boundary, Circle, FenceError, Limits, Polygon, boundary
from sitl.plan.items import Command, Item

HOME = np.zeros(3)
SQUARE = ((-10.0, -10.0), (-10.0, 10.0), (10.0, 10.0), (10.0, -10.0))


def polygon(kind: Command, *corners: tuple[float, float], count: int | None = None) -> tuple[Item, ...]:
    number = float(len(corners) if count is None else count)
    return tuple(item(kind, north, east, params=(number, 0.0, 0.0, 0.0)) for north, east in corners)


def circle(kind: Command, north: float, east: float, radius: float) -> tuple[Item, ...]:
    return (item(kind, north, east, params=(radius, 0.0, 0.0, 0.0)),)


inside = st.floats(-9.99, 9.99)
outside = st.floats(10.01, 1000.0) | st.floats(-1000.0, -10.01)


@given(inside, inside)
def test_a_square_contains_what_is_inside(north: float, east: float) -> None:
    assert Polygon(np.array(SQUARE)).contains(north, east)


@given(outside, st.floats(-1000.0, 1000.0), st.booleans())
def test_a_square_does_not_contain_what_is_outside(far: float, other: float, swapped: bool) -> None:
    north, east = (other, far) if swapped else (far, other)
    assert not Polygon(np.array(SQUARE)).contains(north, east)


@given(st.floats(0.0, 2.0 * math.pi), st.floats(0.0, 40.0))
def test_a_polygon_of_many_corners_is_nearly_a_circle(bearing: float, distance: float) -> None:
    angles = np.linspace(0.0, 2.0 * math.pi, 200, endpoint=False)
    many = Polygon(20.0 * np.column_stack((np.cos(angles), np.sin(angles))))
    round_one = Circle(0.0, 0.0, 20.0)
    north, east = distance * math.cos(bearing), distance * math.sin(bearing)
    assert abs(distance - 20.0) < 0.01 or many.contains(north, east) == round_one.contains(north, east)


def test_a_concave_polygon_has_a_bay() -> None:
    bay = Polygon(
        np.array(((0.0, 0.0), (0.0, 10.0), (10.0, 10.0), (10.0, 6.0), (2.0, 5.0), (10.0, 4.0), (10.0, 0.0)))
    )
    assert bay.contains(8.0, 8.0)
    assert not bay.contains(8.0, 5.0)


def test_items_make_inclusions_and_exclusions() -> None:
    items = polygon(Command.FENCE_INCLUSION_VERTEX, *SQUARE) + circle(
        Command.FENCE_EXCLUSION_CIRCLE, 5.0, 5.0, 2.0
    )
    areas = boundary(items)
    assert (len(areas.inclusions), len(areas.exclusions)) == (1, 1)
    assert areas.allows(0.0, 0.0)
    assert not areas.allows(5.0, 5.0)
    assert not areas.allows(20.0, 0.0)


def test_only_what_lies_in_all_inclusions_is_allowed() -> None:
    areas = boundary(
        polygon(Command.FENCE_INCLUSION_VERTEX, *SQUARE)
        + circle(Command.FENCE_INCLUSION_CIRCLE, 15.0, 0.0, 8.0)
    )
    assert not areas.allows(20.0, 0.0)
    assert areas.allows(9.0, 0.0)


@pytest.mark.parametrize(
    "items",
    [
        polygon(Command.FENCE_INCLUSION_VERTEX, *SQUARE[:2]),
        polygon(Command.FENCE_INCLUSION_VERTEX, *SQUARE, count=5),
        circle(Command.FENCE_EXCLUSION_CIRCLE, 0.0, 0.0, 0.0),
        circle(Command.FENCE_EXCLUSION_CIRCLE, 0.0, 0.0, math.nan),
    ],
)
def test_items_that_make_no_area_are_refused(items: tuple[Item, ...]) -> None:
    with pytest.raises(FenceError, match="fence item 0"):
        boundary(items)


@pytest.mark.parametrize(
    ("place", "broken"),
    [
        ((0.0, 0.0, -5.0), ""),
        ((0.0, 0.0, -31.0), "altitude"),
        ((0.0, 0.0, 2.0), "altitude"),
        ((60.0, 0.0, -5.0), "distance"),
        ((0.0, 40.0, -5.0), "boundary"),
    ],
)
def test_limits_tell_which_of_them_is_broken(place: tuple[float, float, float], broken: str) -> None:
    areas = Boundary(inclusions=(Circle(0.0, 0.0, 30.0),))
    limits = Limits(distance=50.0, height=30.0, least_height=-1.0, boundary=areas)
    assert limits.broken_at(np.array(place), HOME) == broken


def test_height_counts_from_home() -> None:
    assert Limits(height=10.0).broken_at(np.array((0.0, 0.0, -15.0)), np.array((0.0, 0.0, -6.0))) == ""
