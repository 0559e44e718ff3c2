import asyncio
from typing import Any

import pytest
from fake_vehicle import FakeVehicle, in_virtual_time

from companion import clock
from companion.errors import NoReplyError, RefusedError
from companion.link.command import command, request_message, set_message_interval
from companion.link.connection import connect_over
from companion.link.dialect import Message, mavlink
from companion.link.parameter import read_parameter

ARM = mavlink.MAV_CMD_COMPONENT_ARM_DISARM
Command = mavlink.MAVLink_command_long_message
ReadParameter = mavlink.MAVLink_param_request_read_message


def ack(result: int, command_id: int = ARM, target: tuple[int, int] = (1, 191)) -> Message:
    return mavlink.MAVLink_command_ack_message(command_id, result, 0, 0, *target)


def say(text: str, severity: int = mavlink.MAV_SEVERITY_CRITICAL) -> Message:
    return mavlink.MAVLink_statustext_message(severity, text.encode())


@in_virtual_time
async def test_an_accepted_command_goes_out_once_with_its_parameters() -> None:
    vehicle = FakeVehicle()
    vehicle.script[Command] = lambda message: [ack(0), ack(0)]  # PX4 acknowledges OFFBOARD twice
    async with connect_over(vehicle.open) as connection:
        await command(connection, ARM, 1.0, 21196.0)
        (sent,) = vehicle.heard_of(Command)
        assert (sent.command, sent.param1, sent.param2, sent.param7) == (ARM, 1.0, 21196.0, 0.0)
        assert (sent.target_system, sent.target_component) == (1, 1)


@in_virtual_time
async def test_a_refusal_carries_the_vehicles_reason() -> None:
    vehicle = FakeVehicle()
    vehicle.script[Command] = lambda message: [
        ack(mavlink.MAV_RESULT_TEMPORARILY_REJECTED),
        say("Arming denied: no position"),
        say("nice weather", mavlink.MAV_SEVERITY_INFO),
    ]
    async with connect_over(vehicle.open) as connection:
        with pytest.raises(RefusedError) as caught:
            await command(connection, ARM, 1.0)
    assert "COMPONENT_ARM_DISARM (TEMPORARILY_REJECTED): Arming denied: no position" in str(caught.value)
    assert "weather" not in str(caught.value)


@in_virtual_time
async def test_the_reason_may_come_before_the_answer_but_not_from_earlier_times() -> None:
    vehicle = FakeVehicle()
    vehicle.script[Command] = lambda message: [say("no GPS"), ack(mavlink.MAV_RESULT_DENIED)]
    async with connect_over(vehicle.open) as connection:
        vehicle.say(say("old trouble"))
        await asyncio.sleep(1.0)
        with pytest.raises(RefusedError, match=r"\(DENIED\): no GPS$"):
            await command(connection, ARM, 1.0)


@in_virtual_time
async def test_silence_is_asked_again_and_then_told() -> None:
    vehicle = FakeVehicle()
    async with connect_over(vehicle.open) as connection:
        before_s = clock.now()
        with pytest.raises(NoReplyError, match="COMPONENT_ARM_DISARM, asked 4 times"):
            await command(connection, ARM, 1.0)
        assert clock.now() == pytest.approx(before_s + 2.0)
    assert [sent.confirmation for sent in vehicle.heard_of(Command)] == [0, 1, 2, 3]


@in_virtual_time
async def test_a_lost_answer_is_made_up_for() -> None:
    vehicle = FakeVehicle()
    vehicle.script[Command] = lambda message: [ack(0)] if message.confirmation == 2 else []
    async with connect_over(vehicle.open) as connection:
        await command(connection, ARM, 1.0)
        assert len(vehicle.heard_of(Command)) == 3


@in_virtual_time
async def test_answers_to_other_commands_and_other_peers_are_not_ours() -> None:
    vehicle = FakeVehicle()
    not_ours = [
        answer
        for result in (mavlink.MAV_RESULT_DENIED, mavlink.MAV_RESULT_ACCEPTED)
        for answer in (ack(result, mavlink.MAV_CMD_NAV_LAND), ack(result, target=(255, 190)))
    ]
    vehicle.script[Command] = lambda message: [*not_ours, ack(0)] if message.confirmation == 1 else not_ours
    async with connect_over(vehicle.open) as connection:
        await command(connection, ARM, 1.0)
        assert len(vehicle.heard_of(Command)) == 2


@in_virtual_time
async def test_progress_is_waited_for_without_asking_again() -> None:
    vehicle = FakeVehicle()

    def answer(message: Any) -> list[Message]:
        asyncio.get_running_loop().call_later(4.0, vehicle.say, ack(mavlink.MAV_RESULT_ACCEPTED))
        return [ack(mavlink.MAV_RESULT_IN_PROGRESS)]

    vehicle.script[Command] = answer
    async with connect_over(vehicle.open) as connection:
        await command(connection, ARM, 1.0)
        assert len(vehicle.heard_of(Command)) == 1


@in_virtual_time
async def test_the_same_command_waits_for_its_turn() -> None:
    vehicle = FakeVehicle()
    vehicle.script[Command] = lambda message: [ack(0, mavlink.MAV_CMD_SET_MESSAGE_INTERVAL)]
    async with connect_over(vehicle.open) as connection:
        async with asyncio.TaskGroup() as tasks:
            for message_id in (30, 32, 245):
                tasks.create_task(set_message_interval(connection, message_id, 100.0))
        asked = [(sent.param1, sent.param2) for sent in vehicle.heard_of(Command)]
        assert asked == [(30.0, 10000.0), (32.0, 10000.0), (245.0, 10000.0)]


@in_virtual_time
async def test_a_message_is_requested_until_it_comes() -> None:
    vehicle = FakeVehicle()
    state = mavlink.MAVLink_extended_sys_state_message(0, 2)
    vehicle.script[Command] = lambda message: [state] if message.confirmation else []
    async with connect_over(vehicle.open) as connection:
        answer = await request_message(connection, mavlink.MAVLink_extended_sys_state_message)
        assert answer.landed_state == 2
        assert vehicle.heard_of(Command)[0].param1 == mavlink.MAVLINK_MSG_ID_EXTENDED_SYS_STATE
        vehicle.script.clear()
        with pytest.raises(NoReplyError, match="EXTENDED_SYS_STATE"):
            await request_message(connection, mavlink.MAVLink_extended_sys_state_message)


@pytest.mark.parametrize(
    ("wire", "kind", "value"),
    [
        (3.5, mavlink.MAV_PARAM_TYPE_REAL32, 3.5),
        (7e-45, mavlink.MAV_PARAM_TYPE_INT32, 5.0),  # the bytes of the integer 5, read as a float
        (float("nan"), mavlink.MAV_PARAM_TYPE_REAL32, None),
    ],
)
def test_parameters_are_read_as_px4_writes_them(wire: float, kind: int, value: float | None) -> None:
    @in_virtual_time
    async def scenario() -> None:
        vehicle = FakeVehicle()
        vehicle.script[ReadParameter] = lambda message: [
            mavlink.MAVLink_param_value_message(b"OTHER", 9.0, 9, 2, 0),
            mavlink.MAVLink_param_value_message(b"MPC_Z_VEL_MAX_UP", wire, kind, 2, 1),
        ]
        async with connect_over(vehicle.open) as connection:
            read = await read_parameter(connection, "MPC_Z_VEL_MAX_UP")
            assert read == value or (value is None and read != read)

    scenario()


@in_virtual_time
async def test_a_parameter_that_is_not_there_is_told() -> None:
    vehicle = FakeVehicle()
    async with connect_over(vehicle.open) as connection:
        with pytest.raises(NoReplyError, match="MPC_NONE"):
            await read_parameter(connection, "MPC_NONE")
    assert len(vehicle.heard_of(ReadParameter)) == 3
