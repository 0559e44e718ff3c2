import asyncio
from dataclasses import replace

import pytest
from hypothesis import given
from mission_vehicle import ARDUPILOT, FENCE, MISSION, PX4, RALLY, MissionVehicle, in_virtual_time
from plans import fences, missions, places, waypoint

from companion.errors import FlightError, InputError, NoReplyError, RefusedError
from companion.geodesy import Place
from companion.link.connection import connect_over
from companion.link.dialect import mavlink
from companion.link.mission import WireItem
from companion.mission import wire
from companion.mission.items import Fence, FenceCircle, FencePolygon, Frame, MissionItem, Plan
from companion.mission.transfer import clear_plan, download_plan, upload_plan

BOTH = pytest.mark.parametrize("autopilot", [PX4, ARDUPILOT])
HOME = Place(47.397742, 8.545594, 488.0)
TAKEOFF = MissionItem(22, Frame.ABOVE_HOME, (0.0, 0.0, 0.0, None), None, None, 10.0)
JUMP = MissionItem(177, params=(1.0, 3.0, 0.0, 0.0))
PLAN = Plan(
    mission=(TAKEOFF, waypoint(), waypoint(47.3985), JUMP, MissionItem(20)),
    fence=Fence(
        (FencePolygon(((47.3, 8.5), (47.5, 8.5), (47.5, 8.6))), FencePolygon(((1.0, 2.0),) * 4, False)),
        (FenceCircle(47.4, 8.5, 500.0), FenceCircle(47.41, 8.51, 5.0, False)),
        Place(47.4, 8.5, 30.0),
    ),
    rally=(Place(47.401, 8.501, 25.0),),
)
FORMER = [WireItem(3, 16, 1, 0.0, 0.0, 0.0, 0.0, 470_000_000, 80_000_000, 5.0)]


@BOTH
@in_virtual_time
async def test_a_plan_comes_back_as_it_was_sent(autopilot: int) -> None:
    vehicle = MissionVehicle(autopilot)
    shown: list[str] = []
    async with connect_over(vehicle.open) as connection:
        await upload_plan(connection, PLAN, lambda what, done, total: shown.append(what))
        kept = await download_plan(connection)
        assert kept.home == HOME
        assert (kept.fence, kept.rally, kept.firmware) == (PLAN.fence, PLAN.rally, autopilot)
        assert [item.name for item in kept.mission] == [item.name for item in PLAN.mission]
        assert kept.mission[1:3] == PLAN.mission[1:3]
        assert kept.mission[3] == JUMP
        assert list(dict.fromkeys(shown)) == [
            *("uploading fence", "reading back fence"),
            *("uploading rally points", "reading back rally points"),
            *("uploading mission", "reading back mission"),
        ]
        await clear_plan(connection)
        assert await download_plan(connection) == Plan(home=HOME, firmware=autopilot)


@in_virtual_time
async def test_px4_takes_off_at_home_where_no_place_is_named() -> None:
    vehicle = MissionVehicle()
    async with connect_over(vehicle.open) as connection:
        await upload_plan(connection, PLAN)
        takeoff = vehicle.plans[MISSION][0]
        assert (takeoff.x, takeoff.y) == (473_977_420, 85_455_940)
        vehicle.home = None
        with pytest.raises(InputError, match="item 0: NAV_TAKEOFF names no place"):
            await upload_plan(connection, PLAN)


@in_virtual_time
async def test_ardupilot_has_home_first_and_no_nan() -> None:
    vehicle = MissionVehicle(ARDUPILOT)
    async with connect_over(vehicle.open) as connection:
        await upload_plan(connection, PLAN)
        home, takeoff, *_, jump, _ = vehicle.plans[MISSION]
        assert (home.frame, home.command, home.x, home.z) == (0, 16, 473_977_420, 488.0)
        assert (takeoff.param4, takeoff.x) == (0.0, 0)
        assert jump.param1 == 2.0


@BOTH
@in_virtual_time
async def test_a_vehicle_that_refuses_keeps_its_former_mission(autopilot: int) -> None:
    vehicle = MissionVehicle(autopilot)
    vehicle.plans[MISSION] = list(FORMER)
    vehicle.refuses = (2, mavlink.MAV_MISSION_UNSUPPORTED)
    async with connect_over(vehicle.open) as connection:
        with pytest.raises(RefusedError, match=r"refused at item 2 \(UNSUPPORTED\); .*former mission"):
            await upload_plan(connection, Plan(PLAN.mission))
        assert vehicle.plans[MISSION] == FORMER


@in_virtual_time
async def test_px4_keeps_its_former_mission_when_it_stops_answering() -> None:
    vehicle = MissionVehicle()
    vehicle.plans[MISSION] = list(FORMER)
    vehicle.mute_after = 3
    async with connect_over(vehicle.open) as connection:
        with pytest.raises(NoReplyError, match="items into the upload; the vehicle keeps its former mission"):
            await upload_plan(connection, Plan(PLAN.mission))
        assert vehicle.plans[MISSION] == FORMER


@in_virtual_time
async def test_ardupilot_gets_its_former_mission_back_when_it_answers_again() -> None:
    vehicle = MissionVehicle(ARDUPILOT)
    vehicle.plans[MISSION] = list(FORMER)
    vehicle.mute_after = 7
    async with connect_over(vehicle.open) as connection:
        loop = asyncio.get_running_loop()
        loop.call_later(12.0, setattr, vehicle, "mute_after", 10**9)
        with pytest.raises(NoReplyError, match="former mission was uploaded again"):
            await upload_plan(connection, Plan(PLAN.mission))
        assert vehicle.plans[MISSION] == FORMER


@in_virtual_time
async def test_it_is_said_when_ardupilot_may_hold_a_part() -> None:
    vehicle = MissionVehicle(ARDUPILOT)
    vehicle.plans[MISSION] = list(FORMER)
    vehicle.mute_after = 7
    async with connect_over(vehicle.open) as connection:
        with pytest.raises(NoReplyError, match="left with a part of the new mission"):
            await upload_plan(connection, Plan(PLAN.mission))


@pytest.mark.parametrize(
    ("autopilot", "what"),
    [(PX4, "the vehicle keeps its former mission"), (ARDUPILOT, "its former mission was uploaded again")],
)
@in_virtual_time
async def test_an_upload_that_is_stopped_leaves_the_former_mission(autopilot: int, what: str) -> None:
    vehicle = MissionVehicle(autopilot)
    vehicle.plans[MISSION] = list(FORMER)
    announced: list[str] = []
    async with connect_over(vehicle.open) as connection:

        def stop(doing: str, done: int, total: int) -> None:
            if doing == "uploading mission" and done == 3:
                upload.cancel()

        upload = asyncio.create_task(upload_plan(connection, Plan(PLAN.mission), stop, announced.append))
        with pytest.raises(asyncio.CancelledError):
            await upload
        assert announced == [f"stopped half-way: {what}"]
        assert vehicle.plans[MISSION] == FORMER


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"x": 473_980_100}, r"item 1 as NAV_WAYPOINT at 47\.3980100"),
        ({"command": 17}, "NAV_LOITER_UNLIM"),
        ({"z": 11.0}, "11 m"),
        ({"frame": 0}, "in frame 0"),
    ],
)
@in_virtual_time
async def test_what_the_vehicle_keeps_otherwise_is_told(change: dict[str, float], message: str) -> None:
    vehicle = MissionVehicle()
    vehicle.spoils = lambda item: item._replace(**change) if item.x == 473_980_000 else item  # type: ignore[arg-type]
    async with connect_over(vehicle.open) as connection:
        with pytest.raises(FlightError, match=message):
            await upload_plan(connection, Plan(PLAN.mission))


@in_virtual_time
async def test_other_parameters_may_be_kept_otherwise() -> None:
    vehicle = MissionVehicle()
    vehicle.spoils = lambda item: item._replace(param2=0.0, z=item.z + 0.01, x=item.x + 1)
    async with connect_over(vehicle.open) as connection:
        await upload_plan(connection, Plan((waypoint(), MissionItem(178, params=(1.0, 5.0, 0.0, 0.0)))))
        assert len(vehicle.plans[MISSION]) == 2


@in_virtual_time
async def test_a_plan_without_fence_leaves_the_vehicles_alone() -> None:
    vehicle = MissionVehicle()
    async with connect_over(vehicle.open) as connection:
        await upload_plan(connection, PLAN)
        await upload_plan(connection, replace(PLAN, fence=Fence(), rally=()))
        assert len(vehicle.plans[FENCE]) == 10
        assert len(vehicle.plans[RALLY]) == 1


@in_virtual_time
async def test_what_the_vehicle_sends_may_be_nonsense() -> None:
    vehicle = MissionVehicle()
    vehicle.plans[MISSION] = [FORMER[0]._replace(command=9999)]
    async with connect_over(vehicle.open) as connection:
        with pytest.raises(FlightError, match="the vehicle's item 0: command 9999"):
            await download_plan(connection)
        vehicle.plans = {MISSION: [], FENCE: list(FORMER), RALLY: []}
        with pytest.raises(FlightError, match="NAV_WAYPOINT, which is none of a fence"):
            await download_plan(connection)


@given(missions, places)
def test_missions_survive_the_wire(mission: tuple[MissionItem, ...], home: Place) -> None:
    jumps_right = Plan(mission).mission
    for dialect in (wire.PX4, wire.ARDUPILOT):
        sent = wire.mission_to_wire(jumps_right, home, dialect)
        again = wire.mission_to_wire(wire.mission_from_wire(sent, dialect), home, dialect)
        assert wire.difference(sent, again) is None
        assert [item.command for item in sent] == [item.command for item in again]


@given(fences)
def test_fences_survive_the_wire(fence: Fence) -> None:
    sent = wire.fence_to_wire(fence)
    assert wire.difference(sent, wire.fence_to_wire(wire.fence_from_wire(sent))) is None
