import asyncio
import random

import pytest
from mission_vehicle import ARDUPILOT, FENCE, MISSION, PX4, ROUGH, MissionVehicle, Trouble, in_virtual_time

from companion import clock
from companion.errors import LinkError, NoReplyError, RefusedError
from companion.link.connection import connect_over
from companion.link.dialect import mavlink
from companion.link.mission import WireItem, clear_items, download_items, upload_items

BOTH = pytest.mark.parametrize("autopilot", [PX4, ARDUPILOT])


def some_items(count: int) -> list[WireItem]:
    return [WireItem(3, 16, 1, 0.0, 0.0, 0.0, 0.0, 473_977_420 + n, 85_455_940, 10.0) for n in range(count)]


@BOTH
@in_virtual_time
async def test_what_was_uploaded_is_what_is_downloaded(autopilot: int) -> None:
    vehicle = MissionVehicle(autopilot)
    shown: list[tuple[int, int]] = []
    async with connect_over(vehicle.open) as connection:
        began_s = clock.now()
        await upload_items(connection, MISSION, some_items(20), lambda *done: shown.append(done))
        assert vehicle.plans[MISSION] == some_items(20)
        assert shown == [(number, 20) for number in range(1, 21)]
        shown.clear()
        kept = await download_items(connection, MISSION, lambda *done: shown.append(done))
        assert list(kept) == some_items(20)
        assert shown == [(number, 20) for number in range(1, 21)]
        assert clock.now() == began_s
        sent = [
            message
            for message in vehicle.heard
            if isinstance(message, mavlink.MAVLink_mission_item_int_message)
        ]
        assert [message.current for message in sent] == [1] + [0] * 19
        await clear_items(connection, MISSION)
        assert await download_items(connection, MISSION) == ()


@BOTH
@pytest.mark.parametrize("seed", range(6))
@in_virtual_time
async def test_a_rough_link_delays_a_transfer_and_spoils_nothing(autopilot: int, seed: int) -> None:
    trouble = Trouble(ROUGH.lost, ROUGH.duplicated, ROUGH.reordered, ROUGH.jitter_s, seed)
    vehicle = MissionVehicle(autopilot, trouble)
    async with connect_over(vehicle.open) as connection:
        await upload_items(connection, MISSION, some_items(200))
        assert vehicle.plans[MISSION] == some_items(200)
        assert list(await download_items(connection, MISSION)) == some_items(200)


@in_virtual_time
async def test_kinds_of_plans_are_kept_apart() -> None:
    vehicle = MissionVehicle()
    async with connect_over(vehicle.open) as connection:
        await upload_items(connection, MISSION, some_items(3))
        await upload_items(connection, FENCE, some_items(5))
        assert len(await download_items(connection, MISSION)) == 3
        assert len(await download_items(connection, FENCE)) == 5


@in_virtual_time
async def test_a_refusal_names_item_result_and_reason() -> None:
    vehicle = MissionVehicle()
    vehicle.refuses = (7, mavlink.MAV_MISSION_INVALID_PARAM5_X)
    async with connect_over(vehicle.open) as connection:
        warning = mavlink.MAVLink_statustext_message(mavlink.MAV_SEVERITY_CRITICAL, b"Item 7 is too far")
        asyncio.get_running_loop().call_later(0.1, vehicle.say, warning)
        with pytest.raises(
            RefusedError, match=r"mission: refused at item 7 \(INVALID_PARAM5_X\): Item 7 is too far"
        ):
            await upload_items(connection, MISSION, some_items(20))


@pytest.mark.parametrize("mute_after", [0, 1, 5])
@in_virtual_time
async def test_a_vehicle_that_stops_answering_is_given_up(mute_after: int) -> None:
    vehicle = MissionVehicle()
    vehicle.mute_after = mute_after
    async with connect_over(vehicle.open) as connection:
        began_s = clock.now()
        with pytest.raises(NoReplyError, match="stopped answering"):
            await upload_items(connection, MISSION, some_items(20))
        assert clock.now() - began_s < 10.0
        assert vehicle.plans[MISSION] == []


@in_virtual_time
async def test_a_vehicle_that_stops_sending_is_given_up() -> None:
    vehicle = MissionVehicle()
    vehicle.plans[MISSION] = some_items(20)
    vehicle.mute_after = 5
    async with connect_over(vehicle.open) as connection:
        with pytest.raises(NoReplyError, match="stopped answering MISSION_REQUEST_INT"):
            await download_items(connection, MISSION)


@in_virtual_time
async def test_a_busy_vehicle_is_asked_again() -> None:
    vehicle = MissionVehicle()
    vehicle.busy = 2
    async with connect_over(vehicle.open) as connection:
        await upload_items(connection, MISSION, some_items(3))
        vehicle.busy = 2
        assert len(await download_items(connection, MISSION)) == 3


@in_virtual_time
async def test_a_vehicle_that_stays_busy_is_given_up() -> None:
    vehicle = MissionVehicle()
    vehicle.busy = 1000
    async with connect_over(vehicle.open) as connection:
        with pytest.raises(LinkError, match=r"broke off .*\(ERROR\).*another ground station"):
            await upload_items(connection, MISSION, some_items(3))
        with pytest.raises(LinkError, match="broke off"):
            await download_items(connection, MISSION)


@in_virtual_time
async def test_an_acceptance_that_is_lost_fails_nothing() -> None:
    vehicle = MissionVehicle(ARDUPILOT)
    vehicle.swallows_last_ack = True
    async with connect_over(vehicle.open) as connection:
        await upload_items(connection, MISSION, some_items(3))
        assert vehicle.plans[MISSION] == some_items(3)


@in_virtual_time
async def test_answers_to_others_and_late_ones_are_passed_over() -> None:
    vehicle = MissionVehicle()
    async with connect_over(vehicle.open) as connection:
        loop = asyncio.get_running_loop()
        to_other = mavlink.MAVLink_mission_ack_message(255, 190, mavlink.MAV_MISSION_UNSUPPORTED, MISSION)
        of_fence = mavlink.MAVLink_mission_ack_message(1, 191, mavlink.MAV_MISSION_UNSUPPORTED, FENCE)
        early = mavlink.MAVLink_mission_ack_message(1, 191, mavlink.MAV_MISSION_ACCEPTED, MISSION)
        beyond = mavlink.MAVLink_mission_request_int_message(1, 191, 77, MISSION)
        for message in (to_other, of_fence, early, beyond):
            loop.call_soon(vehicle.say, message)
        await upload_items(connection, MISSION, some_items(30))
        assert vehicle.plans[MISSION] == some_items(30)


@in_virtual_time
async def test_transfers_take_turns() -> None:
    vehicle = MissionVehicle()
    async with connect_over(vehicle.open) as connection, asyncio.TaskGroup() as group:
        for count in random.Random(0).sample(range(1, 20), 5):
            group.create_task(upload_items(connection, MISSION, some_items(count)))
    assert len(vehicle.plans[MISSION]) in range(1, 20)
