import asyncio
import math
from typing import Any

import numpy as np
import pytest
from fake_vehicle import FakeVehicle, in_virtual_time

from companion import clock
from companion.errors import LinkError
from companion.link.connection import connect_over
from companion.link.dialect import Message, mavlink
from companion.link.status import Landed
from companion.link.telemetry import Telemetry, start_telemetry
from companion.state import VehicleState

Command = mavlink.MAVLink_command_long_message
Timesync = mavlink.MAVLink_timesync_message


def position(time_ms: int, x: float = 1.0) -> Message:
    return mavlink.MAVLink_local_position_ned_message(time_ms, x, 2.0, -3.0, 0.1, 0.2, 0.3)


def attitude(time_ms: int, roll: float = 0.1) -> Message:
    return mavlink.MAVLink_attitude_message(time_ms, roll, 0.2, 0.3, 0.4, 0.5, 0.6)


@in_virtual_time
async def test_position_and_attitude_make_a_state() -> None:
    vehicle = FakeVehicle()
    async with connect_over(vehicle.open) as connection:
        telemetry = Telemetry(connection)
        vehicle.say(attitude(1000))
        vehicle.say(position(1000))
        state = await telemetry.next_state(1.0)
        assert telemetry.state is state
        np.testing.assert_allclose(state.position, [1.0, 2.0, -3.0])
        np.testing.assert_allclose(state.velocity, [0.1, 0.2, 0.3], rtol=1e-6)
        np.testing.assert_allclose(state.attitude, [0.1, 0.2, 0.3], rtol=1e-6)
        np.testing.assert_allclose(state.rates, [0.4, 0.5, 0.6], rtol=1e-6)
        assert state.received_s == clock.now()
        assert state.time_s <= state.received_s


@in_virtual_time
async def test_the_attitude_nearest_in_time_is_taken_and_none_that_is_far() -> None:
    vehicle = FakeVehicle()
    async with connect_over(vehicle.open) as connection:
        states: list[VehicleState] = []
        Telemetry(connection).subscribe(states.append)
        vehicle.say(attitude(1000, roll=1.0))
        vehicle.say(attitude(1020, roll=2.0))
        vehicle.say(attitude(1010, roll=3.0))
        vehicle.say(position(1012))
        vehicle.say(position(1119, 1.01))
        vehicle.say(position(1121, 1.02))
        await asyncio.sleep(0.01)
        assert [state.attitude[0] for state in states] == [3.0, 2.0]


@in_virtual_time
async def test_what_comes_late_or_twice_is_dropped() -> None:
    vehicle = FakeVehicle()
    async with connect_over(vehicle.open) as connection:
        telemetry = Telemetry(connection)
        north: list[float] = []
        telemetry.subscribe(lambda state: north.append(float(state.position[0])))
        vehicle.say(attitude(1000))
        for time_ms, x in ((1000, 1.0), (1020, 3.0), (1010, 2.0), (1020, 3.0), (1030, 4.0)):
            vehicle.say(position(time_ms, x))
        await asyncio.sleep(0.01)
        assert north == [1.0, 3.0, 4.0]
        assert telemetry.out_of_order == 2


@in_virtual_time
async def test_a_position_that_stands_still_at_speed_is_no_news() -> None:
    vehicle = FakeVehicle()
    async with connect_over(vehicle.open) as connection:
        telemetry = Telemetry(connection)
        came: list[float] = []
        telemetry.subscribe(lambda state: came.append(float(state.position[0])))
        vehicle.say(attitude(1000))
        for time_ms, x in ((1000, 1.0), (1010, 1.0), (1020, 1.0), (1030, 1.1)):
            vehicle.say(position(time_ms, x))
        at_rest = mavlink.MAVLink_local_position_ned_message(1040, 1.1, 2.0, -3.0, 0.01, 0.0, 0.0)
        vehicle.say(at_rest)
        await asyncio.sleep(0.01)
        assert came == pytest.approx([1.0, 1.1, 1.1])
        assert telemetry.repeated == 2


@in_virtual_time
async def test_states_go_on_after_a_reboot() -> None:
    vehicle = FakeVehicle()
    async with connect_over(vehicle.open) as connection:
        times: list[float] = []
        Telemetry(connection).subscribe(lambda state: times.append(state.time_s))
        for time_ms in (60_000, 60_010, 50, 60):
            vehicle.say(attitude(time_ms))
            vehicle.say(position(time_ms, 1e-3 * time_ms))
            await asyncio.sleep(0.01)
        assert len(times) == 4
        assert times == sorted(set(times))


@pytest.mark.parametrize("bad", [math.nan, math.inf, -math.inf])
def test_numbers_that_are_not_finite_are_dropped_and_counted(bad: float) -> None:
    @in_virtual_time
    async def scenario() -> None:
        vehicle = FakeVehicle()
        async with connect_over(vehicle.open) as connection:
            telemetry = Telemetry(connection)
            vehicle.say(attitude(1000))
            vehicle.say(attitude(1010, roll=bad))
            vehicle.say(position(1010, x=bad))
            vehicle.say(position(1011))
            state = await telemetry.next_state(1.0)
            assert state.is_finite()
            assert telemetry.not_finite == 2

    scenario()


@in_virtual_time
async def test_no_state_in_time_is_an_error() -> None:
    vehicle = FakeVehicle()
    async with connect_over(vehicle.open) as connection:
        with pytest.raises(LinkError, match="no position and attitude"):
            await Telemetry(connection).next_state(2.0)


@in_virtual_time
async def test_rates_are_asked_for_and_a_vehicle_may_refuse_them() -> None:
    vehicle = FakeVehicle()
    vehicle.script[Command] = lambda message: [
        mavlink.MAVLink_command_ack_message(message.command, mavlink.MAV_RESULT_FAILED)
    ]
    async with connect_over(vehicle.open) as connection:
        await start_telemetry(connection)
        asked = {int(sent.param1): sent.param2 for sent in vehicle.heard_of(Command)}
        assert asked[mavlink.MAVLINK_MSG_ID_LOCAL_POSITION_NED] == 10000.0
        assert asked[mavlink.MAVLINK_MSG_ID_ATTITUDE] == 10000.0


@in_virtual_time
async def test_time_is_asked_and_told() -> None:
    vehicle = FakeVehicle()
    vehicle.script[Command] = lambda message: [mavlink.MAVLink_command_ack_message(message.command, 0)]
    vehicle_behind_s = 5.0

    def answer(message: Message) -> list[Message]:
        now_ns = round((clock.now() - vehicle_behind_s) * 1e9)
        asked = message.ts1  # type: ignore[attr-defined]
        return [Timesync(now_ns, asked)] if asked >= 0 else []

    async with connect_over(vehicle.open) as connection:
        await asyncio.sleep(6.0)
        vehicle.script[Timesync] = answer
        telemetry = await start_telemetry(connection)
        await asyncio.sleep(1.0)
        assert len(vehicle.heard_of(Timesync)) >= 10

        vehicle.say(Timesync(0, -77))
        await asyncio.sleep(0.01)
        told = [message for message in vehicle.heard_of(Timesync) if message.ts1 == -77]
        assert [message.tc1 for message in told] == [round((clock.now() - 0.01) * 1e9)]

        for _ in range(50):  # answers to somebody else
            vehicle.say(Timesync(10**9, round(clock.now() * 1e9) - 1))
        sent_s = clock.now()
        sent_ms = round((sent_s - vehicle_behind_s) * 1e3)
        vehicle.say(attitude(sent_ms))
        asyncio.get_running_loop().call_later(0.08, vehicle.say, position(sent_ms))
        state = await telemetry.next_state(1.0)
        assert state.received_s == pytest.approx(sent_s + 0.08)
        assert state.time_s == pytest.approx(sent_s, abs=2e-3)


@in_virtual_time
async def test_others_that_answer_our_questions_do_not_set_our_clock() -> None:
    vehicle = FakeVehicle()
    vehicle.script[Command] = lambda message: [mavlink.MAVLink_command_ack_message(message.command, 0)]

    def answer(question: Any) -> list[Message]:
        for system_id, component_id in ((9, 1), (1, 240), (1, 191)):
            vehicle.say(Timesync(5, question.ts1), system_id=system_id, component_id=component_id)
        return [Timesync(question.ts1, question.ts1)] * 2

    vehicle.script[Timesync] = answer
    async with connect_over(vehicle.open) as connection:
        telemetry = await start_telemetry(connection)
        await asyncio.sleep(2.0)
        sent_s = clock.now()
        vehicle.say(attitude(round(sent_s * 1e3)))
        asyncio.get_running_loop().call_later(0.2, vehicle.say, position(round(sent_s * 1e3)))
        state = await telemetry.next_state(1.0)
        assert state.age_s(clock.now()) == pytest.approx(0.2, abs=2e-3)


@in_virtual_time
async def test_ardupilots_home_counts_by_its_place_on_the_earth() -> None:
    vehicle = FakeVehicle(autopilot=mavlink.MAV_AUTOPILOT_ARDUPILOTMEGA)
    async with connect_over(vehicle.open) as connection:
        telemetry = Telemetry(connection)
        none = (0.0, 0.0, 0.0, [1.0, 0.0, 0.0, 0.0], 0.0, 0.0, 0.0)
        vehicle.say(mavlink.MAVLink_home_position_message(473_978_420, 85_455_940, 487_500, *none))
        await asyncio.sleep(0.01)
        assert telemetry.status.home is None
        vehicle.say(mavlink.MAVLink_gps_global_origin_message(473_977_420, 85_455_940, 489_500))
        await asyncio.sleep(0.01)
        assert telemetry.status.home == pytest.approx([11.13, 0.0, 2.0], abs=0.01)


@in_virtual_time
async def test_status_follows_what_the_vehicle_says() -> None:
    vehicle = FakeVehicle()
    async with connect_over(vehicle.open) as connection:
        telemetry = Telemetry(connection)
        assert not telemetry.status.armed
        assert telemetry.status.landed is Landed.UNDEFINED
        armed = mavlink.MAV_MODE_FLAG_SAFETY_ARMED | mavlink.MAV_MODE_FLAG_CUSTOM_MODE_ENABLED
        vehicle.say(mavlink.MAVLink_heartbeat_message(2, 12, armed, 6 << 16, 4, 3))
        vehicle.say(mavlink.MAVLink_extended_sys_state_message(0, mavlink.MAV_LANDED_STATE_IN_AIR))
        vehicle.say(mavlink.MAVLink_sys_status_message(0, 0, 0, 0, 0, 0, 74, 0, 0, 0, 0, 0, 0))
        vehicle.say(mavlink.MAVLink_home_position_message(0, 0, 0, 1.0, 2.0, 3.0, [1, 0, 0, 0], 0, 0, 0))
        await asyncio.sleep(0.01)
        status = telemetry.status
        assert status.armed
        assert status.custom_mode == 6 << 16
        assert status.landed is Landed.IN_AIR
        assert status.battery == 0.74
        assert status.home is not None
        assert status.home.tolist() == [1.0, 2.0, 3.0]
        vehicle.say(mavlink.MAVLink_extended_sys_state_message(0, 99))
        vehicle.say(mavlink.MAVLink_sys_status_message(0, 0, 0, 0, 0, 0, -1, 0, 0, 0, 0, 0, 0))
        await asyncio.sleep(0.01)
        assert telemetry.status.landed is Landed.UNDEFINED
        assert telemetry.status.battery is None
