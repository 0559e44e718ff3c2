"""Missions on the simulated vehicle, whichever autopilot flies it."""

from collections.abc import Callable

import pytest
from tampered_link import POSCTL, Pilot, TamperedLink, connected, virtually

from companion import clock
from companion.errors import FlightError, LinkError, TakenError
from companion.link.dialect import mavlink
from companion.link.parameter import set_parameters
from companion.link.parameter_encoding import Encoding, Parameter, ParameterType
from companion.link.status import Landed
from companion.mission import Drone, Mission, Place, Plan, run
from companion.mission.progress import fly_mission
from companion.mission.transfer import upload_plan

BOTH = pytest.mark.parametrize("vehicle", ["bebop2", "arducopter_sitl"])
HOME = Place(47.397742, 8.545594, 488.0)
THERE = Mission().takeoff(4).go(6, 0, 4).go(6, 6, 5, hold_s=1)


async def fly(pilot: Pilot, plan: Plan, trouble: Callable[[], None]) -> None:
    """Fly `plan`, with trouble at each item."""
    async for _ in fly_mission(pilot.connection, pilot.telemetry, pilot.autopilot, plan.mission):
        trouble()


@BOTH
def test_a_script_flies_item_by_item_and_lands(vehicle: str) -> None:
    async def script(drone: Drone) -> None:
        await drone.upload(THERE)
        places = {reached.index: drone.position async for reached in drone.fly()}
        assert list(places) == [0, 1, 2]
        assert places[2] == pytest.approx((6, 6, 5), abs=1.0)
        await drone.land()
        assert drone.telemetry.status.landed is Landed.ON_GROUND
        assert drone.position == pytest.approx((6, 6, 0), abs=1.0)

    run(script, f"sitl://{vehicle}")


@BOTH
def test_a_mission_that_returns_is_done_on_the_ground(vehicle: str) -> None:
    async def script(drone: Drone) -> None:
        await drone.upload(THERE.return_home())
        reached = [item.index async for item in drone.fly()]
        assert reached[:3] == [0, 1, 2]
        assert not drone.telemetry.status.armed
        assert drone.position == pytest.approx((0, 0, 0), abs=0.5)

    run(script, f"sitl://{vehicle}")


@BOTH
def test_what_is_on_board_can_be_flown_again(vehicle: str) -> None:
    async def script(drone: Drone) -> None:
        await drone.upload(Mission().takeoff(3).go(2, 0, 3).land(5, 0))
        first = [item.index async for item in drone.fly()]
        again = [item.index async for item in drone.fly()]
        assert again == first

    run(script, f"sitl://{vehicle}")


@BOTH
def test_a_mission_that_was_broken_off_is_flown_from_its_start(vehicle: str) -> None:
    async def script(drone: Drone) -> None:
        await drone.upload(Mission().takeoff(3).go(4, 0, 3).go(8, 0, 3).go(12, 0, 3))
        async for reached in drone.fly():
            if reached.index == 2:
                break
        await drone.hold()
        again = [reached.index async for reached in drone.fly()]
        assert again[-3:] == [1, 2, 3]

    run(script, f"sitl://{vehicle}")


@BOTH
def test_jumps_are_flown(vehicle: str) -> None:
    async def script(drone: Drone) -> None:
        await drone.upload(Mission().takeoff(3).go(4, 0, 3).go(0, 0, 3).repeat(1, 1).go(0, 4, 3))
        assert [item.index async for item in drone.fly()] == [0, 1, 2, 1, 2, 4]

    run(script, f"sitl://{vehicle}")


def test_a_vehicle_that_does_not_disarm_itself_is_done_on_the_ground() -> None:
    async def script(drone: Drone) -> None:
        never = Parameter("COM_DISARM_LAND", -1.0, ParameterType.REAL32)
        await set_parameters(drone.connection, [never], Encoding.BYTEWISE)
        await drone.upload(THERE.return_home())
        assert [item.index async for item in drone.fly()][:3] == [0, 1, 2]
        assert drone.telemetry.status.armed
        await drone.takeoff(3)
        await drone.land()
        assert drone.telemetry.status.landed is Landed.ON_GROUND
        assert drone.position == pytest.approx((0, 0, 0), abs=0.5)

    run(script, "sitl://bebop2")


def test_a_pilot_who_takes_the_vehicle_keeps_it() -> None:
    async def scenario() -> None:
        link = TamperedLink()
        async with connected(link) as pilot:
            plan = THERE.plan(HOME)
            await upload_plan(pilot.connection, plan)
            began_s = clock.now()
            with pytest.raises(TakenError, match="went to POSCTL unasked, at item"):
                await fly(pilot, plan, lambda: link.pilot_switches_to(POSCTL))
            taken_s = clock.now()
            assert taken_s - began_s < 60.0
            assert link.mode == "POSCTL"
            commanded = link.commanded(mavlink.MAV_CMD_DO_SET_MODE)
            assert all(time_s < taken_s for time_s in commanded)

    virtually(scenario())


def test_a_vehicle_that_falls_silent_is_not_waited_for() -> None:
    async def scenario() -> None:
        link = TamperedLink()
        async with connected(link) as pilot:
            plan = THERE.plan(HOME)
            await upload_plan(pilot.connection, plan)
            with pytest.raises(LinkError, match="fell silent"):
                await fly(pilot, plan, lambda: setattr(link, "incoming", lambda message: None))

    virtually(scenario())


def test_no_mission_is_not_flown() -> None:
    async def script(drone: Drone) -> None:
        with pytest.raises(FlightError, match="no mission to fly"):
            async for _ in drone.fly():
                pass
        assert not drone.telemetry.status.armed

    run(script, "sitl://bebop2")


@BOTH
def test_a_link_at_the_edge_of_its_range_carries_200_items_both_ways(vehicle: str) -> None:
    async def script(drone: Drone) -> None:
        mission = Mission().takeoff(5)
        for number in range(199):
            mission = mission.go(number % 10, number // 10, 5)
        await drone.upload(mission)
        sent, kept = mission.items(drone.home, drone.site.earth), (await drone.download()).mission
        assert [item.command for item in kept] == [item.command for item in sent]
        for ours, theirs in zip(sent, kept, strict=True):
            assert theirs.coordinates == pytest.approx(ours.coordinates, abs=2e-7)

    run(script, f"sitl://{vehicle}?conditions=lossy&seed=3")
