"""`companion fly` on mission plans: from the file to the flown path, on the simulated vehicles."""

import json
import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from command_line import Run

from companion import clock
from companion.cli.fly_plan import Planned
from companion.cli.flying import Placed
from companion.errors import InputError
from companion.flight.approach import rest_to_rest
from companion.flight.flight import FlightPlan
from companion.flight.guard import GuardLimits
from companion.geodesy import PX4_EARTH, Place, geodetic_from_ned
from companion.link import connect, start_telemetry
from companion.link.dialect import mavlink
from companion.link.parameter import set_parameters
from companion.link.parameter_encoding import Encoding, Parameter, ParameterType
from companion.mission.files import write_plan
from companion.mission.items import Fence, FenceCircle, Frame, MissionItem, Plan
from companion.mission.transfer import upload_plan
from companion.trajectory import Limits
from sitl.geodesy import HOME as SIMULATED_HOME

HOME = Place(SIMULATED_HOME.latitude_deg, SIMULATED_HOME.longitude_deg, SIMULATED_HOME.altitude_m)
TAKEOFF, WAYPOINT = mavlink.MAV_CMD_NAV_TAKEOFF, mavlink.MAV_CMD_NAV_WAYPOINT


def item(north: float, east: float, command: int = WAYPOINT, altitude_m: float = 5.0) -> MissionItem:
    place = geodetic_from_ned(np.array([north, east, 0.0]), HOME, PX4_EARTH)
    return MissionItem(command, Frame.ABOVE_HOME, x=place.latitude_deg, y=place.longitude_deg, z=altitude_m)


def action(command: int, *params: float) -> MissionItem:
    return MissionItem(command, params=(*params, *[0.0] * 4)[:4])  # type: ignore[arg-type]


SURVEY = Plan(
    mission=(
        item(0.0, 0.0, TAKEOFF),
        action(mavlink.MAV_CMD_DO_CHANGE_SPEED, 1.0, 2.5),
        item(8.0, 0.0),
        action(mavlink.MAV_CMD_DO_SET_CAM_TRIGG_DIST, 5.0),
        item(8.0, 4.0),
        item(0.0, 4.0),
        action(mavlink.MAV_CMD_NAV_LAND),
    ),
    home=HOME,
)


@pytest.mark.parametrize(
    ("vehicle", "name", "technique"),
    [
        ("sitl://bebop2", "survey.plan", ("gp",)),
        ("sitl://arducopter_sitl?conditions=px4", "survey.waypoints", ("dnn+gp", "--model", "ardrone2")),
    ],
)
def test_a_survey_is_tracked_far_closer_than_by_the_baseline(
    vehicle: str, name: str, technique: tuple[str, ...], companion: Run, tmp_path: Path
) -> None:
    plan, result = tmp_path / name, tmp_path / "flight.json"
    write_plan(SURVEY, plan)

    def rms_m(*strategy: str) -> float:
        ran = companion("fly", plan, "--connect", vehicle, "--strategy", *strategy, "--json", result)
        assert ran.status == 0, ran.err
        assert "without DO_SET_CAM_TRIGG_DIST (item 3)" in ran.out
        assert ("landing" in ran.out) == ("hold" not in strategy)
        return float(json.loads(result.read_text())["rms_m"])

    assert rms_m(*technique) < 0.4 * rms_m("baseline", "--after", "hold")


def test_a_dry_run_starts_at_the_planned_home(companion: Run, tmp_path: Path) -> None:
    write_plan(SURVEY, tmp_path / "survey.plan")
    ran = companion("fly", tmp_path / "survey.plan", "--dry-run")
    assert ran.status == 0, ran.err
    assert "to 8.00, east -0.00 to 4.00" in ran.out
    assert "without DO_SET_CAM_TRIGG_DIST (item 3)" in ran.out


def test_a_plan_brings_its_own_box(companion: Run, tmp_path: Path) -> None:
    turned = replace(item(0.0, 120.0, altitude_m=60.0), params=(0.0, 0.0, 0.0, 90.0))
    write_plan(Plan(mission=(item(-80.0, 0.0), turned), home=HOME), tmp_path / "wide.plan")
    ran = companion("fly", tmp_path / "wide.plan", "--dry-run")
    assert ran.status == 0, ran.err
    box = "north -85.0 to 5.0 m, east -5.0 to 125.0 m, altitude 0.5 to 65.0 m"
    assert f"no setpoint leaves {box}" in ran.out
    assert "without the yaw given (item 1)" in ran.out


@pytest.mark.parametrize(
    ("plan", "guard", "what"),
    [
        (
            Plan(mission=(item(0.0, 62.0),), home=HOME),
            "{}",
            "item 0 is 12.0 m beyond the guard's fence, east",
        ),
        (Plan(mission=(item(40.0, 0.0),), home=HOME), "max_distance_m: 30", "more than max_distance_m 30"),
        (
            Plan(
                mission=(item(40.0, 0.0),),
                fence=Fence(circles=(FenceCircle(HOME.latitude_deg, HOME.longitude_deg, 25.0),)),
                home=HOME,
            ),
            "{}",
            "15.0 m beyond the plan's fence near item 0",
        ),
        (Plan(mission=(item(5.0, 0.0),)), "{}", "no planned home position"),
    ],
)
def test_what_leads_too_far_is_refused(
    plan: Plan, guard: str, what: str, companion: Run, tmp_path: Path
) -> None:
    file, limits = tmp_path / "far.plan", tmp_path / "guard.yaml"
    write_plan(plan, file)
    limits.write_text(guard)
    ran = companion("fly", file, "--dry-run", "--guard", limits)
    assert ran.status == 2
    assert what in ran.err


def test_a_plan_elsewhere_on_earth_is_refused_before_takeoff(companion: Run, tmp_path: Path) -> None:
    place = geodetic_from_ned(np.array([2000.0, 0.0, 0.0]), HOME, PX4_EARTH)
    far = MissionItem(WAYPOINT, Frame.ABOVE_HOME, x=place.latitude_deg, y=place.longitude_deg, z=5.0)
    write_plan(Plan(mission=(far,)), tmp_path / "far.plan")
    ran = companion("fly", tmp_path / "far.plan", "--connect", "sitl://bebop2")
    assert ran.status == 2
    assert "item 0 is 2000.0 m from the vehicle, 1500.0 m more than max_distance_m 500" in ran.err
    assert "arming" not in ran.out


def test_the_vehicles_own_fence_counts() -> None:
    async def scenario() -> None:
        async with connect("sitl://bebop2") as connection:
            telemetry = await start_telemetry(connection)
            fence = Fence(circles=(FenceCircle(HOME.latitude_deg, HOME.longitude_deg, 5.0),))
            await upload_plan(connection, Plan(mission=SURVEY.mission[:3], fence=fence))
            flight = Planned("survey", SURVEY, FlightPlan, GuardLimits(), None, False)
            with pytest.raises(InputError, match="beyond the vehicle's fence near item"):
                await flight.lay(connection, telemetry, Limits(), lambda text: None)

    clock.run(scenario(), virtual=True)


def test_the_vehicles_own_fence_counts_for_drawings_and_is_given_to_the_guard() -> None:
    async def laid(radius_m: float) -> FlightPlan:
        async with connect("sitl://bebop2") as connection:
            telemetry = await start_telemetry(connection)
            fence = Fence(circles=(FenceCircle(HOME.latitude_deg, HOME.longitude_deg, radius_m),))
            await upload_plan(connection, Plan(mission=SURVEY.mission[:3], fence=fence))
            way = rest_to_rest(np.array([0.0, 0.0, -2.0]), np.array([8.0, 0.0, -2.0]), "way")
            drawing = Placed(FlightPlan(way), lambda limits: way)
            return await drawing.lay(connection, telemetry, Limits(), lambda text: None)

    with pytest.raises(InputError, match=r"way is 3\.\d+ m beyond the vehicle's fence"):
        clock.run(laid(5.0), virtual=True)
    (circle,) = clock.run(laid(10.0), virtual=True).vehicle_fence.circles
    assert (circle.radius_m, circle.keep_out) == (10.0, False)
    assert math.hypot(circle.north_m, circle.east_m) < 1.0


def test_a_plan_that_climbs_beyond_the_vehicles_own_ceiling_is_refused() -> None:
    async def scenario() -> None:
        async with connect("sitl://bebop2") as connection:
            telemetry = await start_telemetry(connection)
            ceiling = Parameter("GF_MAX_VER_DIST", 5.2, ParameterType.REAL32)
            assert not await set_parameters(connection, [ceiling], Encoding.BYTEWISE)
            flight = Planned("survey", SURVEY, FlightPlan, GuardLimits(), None, False)
            with pytest.raises(
                InputError, match=r"survey is 0\.30 m beyond what the vehicle's GF_MAX_VER_DIST"
            ):
                await flight.lay(connection, telemetry, Limits(), lambda text: None)

    clock.run(scenario(), virtual=True)
