import math
from itertools import pairwise

import pytest

from companion.errors import InputError
from companion.geodesy import PX4_EARTH, ned_from_geodetic
from companion.mission import Frame, Mission, Place
from companion.mission.items import MissionItem

HOME = Place(47.397742, 8.545594, 488.0)


def offset(item: MissionItem) -> tuple[float, float, float]:
    place = item.place(HOME)
    assert place is not None
    north, east, down = ned_from_geodetic(place, HOME, PX4_EARTH)
    return round(north, 3), round(east, 3), round(-down, 3)


def test_metres_become_degrees_on_the_earth_that_the_vehicle_believes_in() -> None:
    mission = Mission().takeoff(5).go(100, -50, 8).land(3, 4)
    assert [offset(item) for item in mission.items(HOME, PX4_EARTH)] == [(0, 0, 5), (100, -50, 8), (3, 4, 0)]
    assert mission.plan(HOME).home == HOME


def test_every_step_leaves_the_mission_before_it_as_it_is() -> None:
    start = Mission().takeoff(5)
    assert len(start.return_home()) == 2
    assert len(start) == 1


def test_steps_become_the_commands_of_mavlink() -> None:
    mission = Mission().takeoff(5).speed(3).waypoint(47.4, 8.5, 10, hold_s=2, within_m=1, heading_deg=90)
    takeoff, speed, waypoint = mission.items(HOME)
    assert (takeoff.name, takeoff.z, takeoff.params[3]) == ("NAV_TAKEOFF", 5.0, None)
    assert (speed.name, speed.frame, speed.params[1]) == ("DO_CHANGE_SPEED", Frame.NONE, 3.0)
    assert (waypoint.coordinates, waypoint.z) == ((47.4, 8.5), 10.0)
    assert waypoint.params == (2.0, 1.0, 0.0, 90.0)


def test_a_survey_covers_its_rectangle_in_lines_to_and_fro() -> None:
    mission = Mission().survey((0, 0), (20, 10), 8, spacing_m=4)
    places = [offset(item) for item in mission.items(HOME, PX4_EARTH)]
    assert [north for north, _, _ in places] == [0, 20, 20, 0, 0, 20, 20, 0]
    lines = [east for _, east, _ in places[::2]]
    assert (lines[0], lines[-1]) == (0, 10)
    assert max(b - a for a, b in pairwise(lines)) <= 4


def test_an_orbit_looks_at_its_centre() -> None:
    items = Mission().orbit((10, 20), 5, 6, points=8).items(HOME, PX4_EARTH)
    assert len(items) == 9
    assert offset(items[0]) == offset(items[-1]) == (5, 20, 6)
    for item in items:
        north, east, _ = offset(item)
        assert math.hypot(north - 10, east - 20) == pytest.approx(5, abs=2e-3)
        heading = math.radians(item.params[3] or 0.0)
        assert (north + 5 * math.cos(heading), east + 5 * math.sin(heading)) == pytest.approx(
            (10, 20), abs=2e-3
        )
    assert offset(items[2]) == (10, 15, 6)  # clockwise: from its south to its west


def test_a_jump_must_lead_to_a_step() -> None:
    assert Mission().takeoff(5).go(1, 0, 5).repeat(1, 2).plan(HOME).mission[2].params[:2] == (1.0, 2.0)
    with pytest.raises(InputError, match="jumps to item 7"):
        Mission().takeoff(5).repeat(7, 2).plan(HOME)


@pytest.mark.parametrize(
    "build",
    [
        lambda: Mission().takeoff(0),
        lambda: Mission().takeoff(math.nan),
        lambda: Mission().speed(-1),
        lambda: Mission().orbit((0, 0), 0, 5),
        lambda: Mission().orbit((0, 0), 5, 5, points=2),
        lambda: Mission().survey((0, 0), (10, 10), 5, spacing_m=0),
        lambda: Mission().survey((10, 0), (0, 10), 5, spacing_m=2),
        lambda: Mission().waypoint(91, 0, 5),
        lambda: Mission().go(0, 0, math.inf),
    ],
)
def test_what_cannot_be_flown_is_refused_at_once(build: object) -> None:
    with pytest.raises(InputError):
        build()  # type: ignore[operator]
