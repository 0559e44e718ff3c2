import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from companion.errors import InputError
from companion.geodesy import PX4_EARTH, Place, geodetic_from_ned
from companion.mission.boundaries import areas_of, require_inside_areas, require_inside_box, require_near
from companion.mission.items import Fence, FenceCircle, FencePolygon
from companion.mission.path import Ending, TrackedPath
from companion.mission.site import Site
from companion.trajectory import Limits
from companion.trajectory.route import Waypoint
from companion.trajectory.waypoints import trajectory_through

HOME = Place(47.397742, 8.545594, 488.0)
SITE = Site(HOME, PX4_EARTH, np.zeros(3))


def path_through(*places: tuple[float, float, float]) -> TrackedPath:
    waypoints = tuple(Waypoint(np.array(place)) for place in places)
    return TrackedPath(waypoints, (None, *range(1, len(places))), 5.0, Ending.HOLD, ())


def degrees(north: float, east: float) -> tuple[float, float]:
    place = geodetic_from_ned(np.array([north, east, 0.0]), HOME, PX4_EARTH)
    return place.latitude_deg, place.longitude_deg


def square(half_m: float, east: float = 0.0, *, inclusion: bool = True) -> FencePolygon:
    corners = [(-half_m, -half_m), (-half_m, half_m), (half_m, half_m), (half_m, -half_m)]
    return FencePolygon(tuple(degrees(north, east + offset) for north, offset in corners), inclusion)


def check_fence(fence: Fence, *places: tuple[float, float, float]) -> None:
    path = path_through(*places)
    trajectory = trajectory_through("path", path.waypoints, Limits())
    require_inside_areas(path, trajectory, areas_of(fence, SITE), "plan")


def test_near_enough_or_named() -> None:
    path = path_through((0, 0, -10), (30, 40, -10), (0, 60, -10))
    require_near(path, np.array([0.0, 0.0, -10.0]), 60.0)
    with pytest.raises(
        InputError, match=r"item 2 is 60\.0 m from the vehicle, 10\.0 m more than max_distance_m 50"
    ):
        require_near(path, np.array([0.0, 0.0, -10.0]), 50.0)


@pytest.mark.parametrize(
    ("place", "what"),
    [
        ((57.0, 0.0, -10.0), r"item 1 is 7\.0 m beyond the guard's fence, north: .*north_m"),
        ((0.0, -51.5, -10.0), r"1\.5 m .* west: .*east_m"),
        ((0.0, 0.0, -52.0), r"2\.0 m .* upwards: .*altitude_m"),
        ((0.0, 0.0, -0.2), r"0\.3 m .* downwards: .*altitude_m"),
    ],
)
def test_the_guards_box(place: tuple[float, float, float], what: str) -> None:
    corners = np.array([-50.0, -50.0, -50.0]), np.array([50.0, 50.0, -0.5])
    require_inside_box(path_through((0, 0, -5), (50, -50, -50)), *corners)
    with pytest.raises(InputError, match=what):
        require_inside_box(path_through((0, 0, -5), place), *corners)


def test_inclusion_areas_are_kept_to() -> None:
    """By the path that is flown, which cuts the corner by a metre."""
    fence = Fence(polygons=(square(20.0),), circles=(FenceCircle(*degrees(0.0, 30.0), 15.0),))
    check_fence(fence, (0, 0, -10), (0, 40, -10))  # from the one into the other
    with pytest.raises(InputError, match=r"9\.0 m beyond the plan's fence near item 2"):
        check_fence(fence, (0, 0, -10), (5, 5, -10), (30, 0, -10), (0, 0, -10))


def test_exclusion_areas_are_kept_out_of_even_between_waypoints() -> None:
    fence = Fence(polygons=(square(3.0, east=20.0, inclusion=False),))
    check_fence(fence, (0, 0, -10), (10, 0, -10), (10, 40, -10))
    with pytest.raises(InputError, match=r"3\.0 m beyond the plan's fence"):
        check_fence(fence, (0, 0, -10), (0, 40, -10))


def test_no_fence_forbids_nothing() -> None:
    check_fence(Fence(), (0, 0, -10), (0, 400, -10))
    assert areas_of(Fence(), SITE).beyond_m(np.array([0.0, 400.0])) <= 0.0


@given(north=st.floats(-50.0, 50.0), east=st.floats(-50.0, 50.0))
def test_a_square_and_its_point(north: float, east: float) -> None:
    """The distance to a square is that to its nearest side, by arithmetic of its own."""
    inside = max(abs(north), abs(east)) <= 20.0
    beyond_m = float(np.hypot(max(abs(north) - 20.0, 0.0), max(abs(east) - 20.0, 0.0)))
    if inside or beyond_m < 0.01:
        check_fence(Fence(polygons=(square(20.01),)), (north, east, -10.0))
    else:
        with pytest.raises(InputError, match=f"{beyond_m - 1e-3:.0f}|{beyond_m:.1f}|{beyond_m + 0.05:.1f}"):
            check_fence(Fence(polygons=(square(20.0),)), (north, east, -10.0))
