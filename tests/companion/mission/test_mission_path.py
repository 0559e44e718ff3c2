import math

import numpy as np
import pytest

from companion.errors import InputError
from companion.geodesy import PX4_EARTH, Place, geodetic_from_ned
from companion.link.dialect import mavlink
from companion.mission.items import Frame, MissionItem, Plan
from companion.mission.path import Ending, TrackedPath, tracked_path
from companion.mission.site import Site, planned_site

HOME = Place(47.397742, 8.545594, 488.0)
GROUND = Site(HOME, PX4_EARTH, np.zeros(3))


def item(
    command: str, north: float = 0.0, east: float = 0.0, altitude_m: float = 10.0, **changes: object
) -> MissionItem:
    """An item at a place this far from home (m)."""
    place = geodetic_from_ned(np.array([north, east, 0.0]), HOME, PX4_EARTH)
    fields = {"frame": Frame.ABOVE_HOME, "x": place.latitude_deg, "y": place.longitude_deg, "z": altitude_m}
    return MissionItem(getattr(mavlink, f"MAV_CMD_{command}"), **(fields | changes))  # type: ignore[arg-type]


def action(command: str, *params: float) -> MissionItem:
    return MissionItem(getattr(mavlink, f"MAV_CMD_{command}"), params=(*params, *[0.0] * 4)[:4])  # type: ignore[arg-type]


def path_of(*items: MissionItem, site: Site = GROUND) -> TrackedPath:
    return tracked_path(Plan(mission=items, home=HOME), site)


def places(path: TrackedPath) -> list[tuple[float, float, float]]:
    return [tuple(waypoint.position.round(2).tolist()) for waypoint in path.waypoints]


def test_takeoff_waypoints_and_return() -> None:
    path = path_of(
        item("NAV_TAKEOFF", altitude_m=5.0),
        item("NAV_WAYPOINT", 20.0, 0.0),
        item("NAV_WAYPOINT", 20.0, -30.0, params=(3.0, 2.0, 0.0, None)),
        action("NAV_RETURN_TO_LAUNCH"),
        item("NAV_WAYPOINT", 99.0, 0.0),
    )
    assert places(path) == [(0, 0, -5), (20, 0, -10), (20, -30, -10)]
    assert path.items == (None, 1, 2)
    assert (path.takeoff_altitude_m, path.ending, path.remarks) == (5.0, Ending.RETURN, ())
    assert [waypoint.hold_s for waypoint in path.waypoints] == [0.0, 0.0, 3.0]
    assert [waypoint.within_m for waypoint in path.waypoints[1:]] == [1.0, 2.0]


def test_without_takeoff_it_climbs_where_it_stands() -> None:
    assert places(path_of(item("NAV_WAYPOINT", 20.0)))[0] == (0, 0, -10)


def test_a_vehicle_in_the_air_starts_where_it_is() -> None:
    flying = Site(HOME, PX4_EARTH, np.array([1.0, 2.0, 0.5]), airborne=np.array([6.0, 2.0, -7.5]))
    path = path_of(item("NAV_TAKEOFF"), item("NAV_WAYPOINT", 20.0, 0.0), site=flying)
    assert places(path) == [(5, 0, -8), (19, -2, -10)]


def test_altitudes_above_sea_count_from_the_origin() -> None:
    site = Site(HOME, PX4_EARTH, np.array([0.0, 0.0, -2.0]))  # it stands 2 m above its origin
    path = path_of(item("NAV_WAYPOINT", 5.0, altitude_m=500.0, frame=Frame.GLOBAL), site=site)
    assert path.waypoints[1].position[2] == pytest.approx(-10.0)


def test_what_an_item_leaves_open_stays() -> None:
    path = path_of(item("NAV_WAYPOINT", 8.0, 9.0), item("NAV_LOITER_TO_ALT", x=0.0, y=0.0, altitude_m=15.0))
    assert places(path)[-1] == (8, 9, -15)


def test_speeds_holds_and_landing() -> None:
    path = path_of(
        item("NAV_WAYPOINT", 10.0),
        action("DO_CHANGE_SPEED", 1.0, 3.0),
        item("NAV_LOITER_TIME", 20.0, params=(4.0, 0.0, 0.0, 0.0)),
        action("NAV_DELAY", 2.0),
        action("DO_CHANGE_SPEED", 1.0, -2.0),
        item("NAV_LAND", 30.0, altitude_m=0.0),
    )
    assert [waypoint.speed_m_s for waypoint in path.waypoints[1:]] == [5.0, 3.0, 5.0]
    assert path.waypoints[2].hold_s == 6.0
    assert places(path)[-1] == (30, 0, -10)
    assert path.ending is Ending.LAND


@pytest.mark.parametrize("radius_m", [10.0, -10.0])
def test_turns_are_circles(radius_m: float) -> None:
    path = path_of(
        item("NAV_WAYPOINT", 50.0), item("NAV_LOITER_TURNS", 20.0, params=(1.5, 0.0, radius_m, 0.0))
    )
    circle = np.array([waypoint.position for waypoint in path.waypoints[2:]])
    assert np.linalg.norm(circle[:, :2] - [20.0, 0.0], axis=1) == pytest.approx(10.0, abs=1e-3)
    assert circle[0] == pytest.approx([30.0, 0.0, -10.0], abs=1e-3)
    turned = np.unwrap(np.arctan2(circle[:, 1], circle[:, 0] - 20.0))
    assert turned[-1] - turned[0] == pytest.approx(math.copysign(3.0 * math.pi, radius_m))


def test_jumps_are_unrolled() -> None:
    path = path_of(
        item("NAV_WAYPOINT", 10.0), item("NAV_WAYPOINT", 20.0), action("DO_JUMP", 0.0, 2.0), item("NAV_LAND")
    )
    assert path.items == (None, 0, 1, 0, 1, 0, 1, 3)


def test_cameras_are_left_out_and_named() -> None:
    path = path_of(
        item("NAV_WAYPOINT", 10.0),
        action("DO_SET_CAM_TRIGG_DIST", 25.0),
        item("NAV_SPLINE_WAYPOINT", 20.0),
        action("DO_SET_CAM_TRIGG_DIST", 0.0),
    )
    assert path.remarks == (
        "without DO_SET_CAM_TRIGG_DIST (items 1, 3)",
        "straight legs instead of the curve of NAV_SPLINE_WAYPOINT (item 2)",
    )


@pytest.mark.parametrize(
    ("items", "what"),
    [
        ([], "no waypoint"),
        ([action("NAV_RETURN_TO_LAUNCH")], "no waypoint"),
        (
            [item("NAV_WAYPOINT", frame=Frame.ABOVE_TERRAIN)],
            r"item 0 \(NAV_WAYPOINT\): heights above terrain",
        ),
        ([item("NAV_WAYPOINT", params=(-1.0, 0.0, 0.0, 0.0))], "must not be negative"),
        ([item("NAV_WAYPOINT"), item("NAV_TAKEOFF")], "item 1 .*split the plan"),
        ([item("NAV_LOITER_TURNS")], "radius"),
        ([action("NAV_FOLLOW")], "cannot be tracked"),
        ([item("NAV_WAYPOINT"), action("DO_JUMP", 0.0, -1.0)], "for ever"),
        ([item("NAV_WAYPOINT"), action("DO_JUMP", 0.0, 1e6)], "repeat less"),
        ([item("NAV_WAYPOINT"), action("DO_CHANGE_SPEED", 1.0, 0.0)], "never gets anywhere"),
    ],
)
def test_what_cannot_be_tracked_is_refused(items: list[MissionItem], what: str) -> None:
    with pytest.raises(InputError, match=what):
        path_of(*items)


def test_a_plan_without_home_needs_a_vehicle() -> None:
    with pytest.raises(InputError, match="planned home"):
        planned_site(Plan(mission=(item("NAV_WAYPOINT"),)))
