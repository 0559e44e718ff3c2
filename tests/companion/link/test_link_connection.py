import asyncio

import pytest
from fake_vehicle import ONBOARD, FakeVehicle, heartbeat, in_virtual_time

from companion import clock
from companion.errors import FlightError, LinkError, NoReplyError
from companion.link.connection import connect_over
from companion.link.dialect import Message, mavlink

SysStatus = mavlink.MAVLink_extended_sys_state_message


def landed(state: int) -> Message:
    return SysStatus(0, state)


@in_virtual_time
async def test_the_first_vehicle_that_is_heard_is_the_one() -> None:
    vehicle = FakeVehicle(system_id=7)
    async with connect_over(vehicle.open) as connection:
        assert connection.system_id == 7
        assert not connection.lost
        assert connection.heartbeat.autopilot == mavlink.MAV_AUTOPILOT_PX4


@in_virtual_time
async def test_it_heartbeats_as_an_onboard_controller_of_the_vehicle() -> None:
    vehicle = FakeVehicle(system_id=7)
    async with connect_over(vehicle.open):
        await asyncio.sleep(5.0)
    beats = vehicle.heard_of(mavlink.MAVLink_heartbeat_message)
    assert len(beats) in (5, 6)
    last = beats[-1]
    assert (last.get_srcSystem(), last.get_srcComponent()) == (7, 191)
    assert last.type == mavlink.MAV_TYPE_ONBOARD_CONTROLLER
    assert last.autopilot == mavlink.MAV_AUTOPILOT_INVALID


@in_virtual_time
async def test_ground_stations_and_companions_are_no_vehicles() -> None:
    vehicle = FakeVehicle(heartbeats=0)
    loop = asyncio.get_running_loop()
    invalid = mavlink.MAV_AUTOPILOT_INVALID

    async def open_with_others(receiver):  # type: ignore[no-untyped-def]
        transport = await vehicle.open(receiver)
        vehicle.say(heartbeat(invalid, mavlink.MAV_TYPE_GCS), system_id=255, component_id=190)
        vehicle.say(heartbeat(invalid, mavlink.MAV_TYPE_GCS), system_id=255)
        vehicle.say(heartbeat(), system_id=5, component_id=ONBOARD)
        loop.call_later(0.5, vehicle.say, heartbeat())
        return transport

    async with connect_over(open_with_others) as connection:
        assert connection.system_id == 1


@in_virtual_time
async def test_state_and_replies_come_from_no_other_system() -> None:
    vehicle = FakeVehicle(system_id=2)
    async with connect_over(vehicle.open, system_id=2) as connection:
        states: list[int] = []
        connection.subscribe(SysStatus, lambda message: states.append(message.landed_state))
        vehicle.say(landed(1), system_id=1)
        vehicle.say(landed(2), component_id=ONBOARD)
        vehicle.say(heartbeat(), system_id=1)
        vehicle.say(heartbeat(mavlink.MAV_AUTOPILOT_ARDUPILOTMEGA), component_id=ONBOARD)
        vehicle.say(landed(3))
        await asyncio.sleep(0.01)
        assert states == [3]
        assert connection.system_id == 2
        assert connection.heartbeat.autopilot == mavlink.MAV_AUTOPILOT_PX4
        assert connection.strange_frames == 4


@in_virtual_time
async def test_the_wanted_system_is_waited_for() -> None:
    vehicle = FakeVehicle(system_id=1)
    with pytest.raises(LinkError, match="system 2 is silent, but these speak: 1"):
        async with connect_over(vehicle.open, system_id=2, timeout_s=3.0):
            pytest.fail("system 2 is not there")


@pytest.mark.parametrize(
    ("said", "why"),
    [(b"", "nothing arrives"), (bytes(30), "no MAVLink"), (b"system", "no MAVLink")],
)
def test_nothing_there_is_told_in_time(said: bytes, why: str) -> None:
    @in_virtual_time
    async def scenario() -> None:
        vehicle = FakeVehicle(heartbeats=0)
        asyncio.get_running_loop().call_later(0.5, lambda: vehicle.transport.deliver(said))
        with pytest.raises(LinkError, match=why):
            async with connect_over(vehicle.open, timeout_s=10.0):
                pytest.fail("nothing is there")
        assert clock.now() == pytest.approx(10.0)

    scenario()


@in_virtual_time
async def test_a_silent_vehicle_counts_as_lost() -> None:
    vehicle = FakeVehicle(heartbeats=2)
    async with connect_over(vehicle.open) as connection:
        seen = []
        for wait_s in (3.5, 1.0, 0.01):  # heartbeats at 0.1 s, 1.1 s, and at the end
            await asyncio.sleep(wait_s)
            seen.append(connection.lost)
            if connection.lost:
                vehicle.say(heartbeat())
        assert seen == [False, True, False]


@in_virtual_time
async def test_messages_reach_every_subscriber_in_order_until_it_leaves() -> None:
    vehicle = FakeVehicle()
    async with connect_over(vehicle.open) as connection:
        first: list[int] = []
        second: list[int] = []
        leave = connection.subscribe(SysStatus, lambda message: first.append(message.landed_state))
        connection.subscribe(SysStatus, lambda message: second.append(message.landed_state))
        for state in (1, 2, 3):
            vehicle.say(landed(state))
        await asyncio.sleep(0.01)
        leave()
        vehicle.say(landed(4))
        await asyncio.sleep(0.01)
        assert first == [1, 2, 3]
        assert second == [1, 2, 3, 4]


@in_virtual_time
async def test_receive_waits_for_what_matches_and_no_longer_than_told() -> None:
    vehicle = FakeVehicle()
    async with connect_over(vehicle.open) as connection:
        for delay, state in enumerate((1, 2, 3), start=1):
            asyncio.get_running_loop().call_later(delay, vehicle.say, landed(state))
        message = await connection.receive(
            SysStatus, lambda message: message.landed_state == 2, timeout_s=5.0
        )
        assert message.landed_state == 2
        before_s = clock.now()
        with pytest.raises(NoReplyError, match="EXTENDED_SYS_STATE"):
            await connection.receive(SysStatus, lambda message: False, timeout_s=4.0)
        assert clock.now() == pytest.approx(before_s + 4.0)


@in_virtual_time
async def test_an_error_in_a_handler_ends_the_block_and_comes_out_as_it_is() -> None:
    vehicle = FakeVehicle()

    def fail(message: Message) -> None:
        raise FlightError("cannot go on")

    async def use() -> None:
        async with connect_over(vehicle.open) as connection:
            connection.subscribe(SysStatus, fail)
            vehicle.say(landed(1))
            await asyncio.sleep(60.0)

    with pytest.raises(FlightError, match="cannot go on"):
        await use()
    assert clock.now() < 1.0


@in_virtual_time
async def test_a_task_that_fails_ends_the_others_and_the_block() -> None:
    vehicle = FakeVehicle()
    ended: list[str] = []

    async def wait_for_ever() -> None:
        try:
            await asyncio.Event().wait()
        finally:
            ended.append("other")

    async def fail() -> None:
        await asyncio.sleep(1.0)
        raise FlightError("failed") from ValueError("the cause")

    async def use() -> None:
        async with connect_over(vehicle.open) as connection:
            connection.spawn(wait_for_ever())
            connection.spawn(fail())
            await asyncio.sleep(60.0)

    with pytest.raises(FlightError, match="failed") as caught:
        await use()
    assert ended == ["other"]
    assert isinstance(caught.value.__cause__, ValueError)


@in_virtual_time
async def test_an_error_of_the_block_itself_comes_out_as_it_is() -> None:
    with pytest.raises(KeyError):
        async with connect_over(FakeVehicle().open):
            raise KeyError


@in_virtual_time
async def test_cancelling_leaves_nothing_running() -> None:
    vehicle = FakeVehicle()
    closed: list[bool] = []

    async def use() -> None:
        async with connect_over(vehicle.open) as connection:
            close = connection.transport.aclose

            async def aclose() -> None:
                await close()
                closed.append(True)

            vehicle.transport.aclose = aclose  # type: ignore[method-assign]
            await asyncio.Event().wait()

    task = asyncio.create_task(use())
    await asyncio.sleep(5.0)
    task.cancel()
    with pytest.raises(asyncio.CancelledError):
        await task
    assert closed == [True]
