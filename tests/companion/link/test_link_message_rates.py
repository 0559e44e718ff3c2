import asyncio
from collections import Counter
from collections.abc import Container, Iterable

from fake_vehicle import FakeVehicle, in_virtual_time

from companion import clock
from companion.link.connection import Connection, connect_over
from companion.link.dialect import Message, mavlink
from companion.link.message_rates import MessageRates
from companion.link.telemetry import start_telemetry

Command = mavlink.MAVLink_command_long_message
ATTITUDE, HOME = mavlink.MAVLINK_MSG_ID_ATTITUDE, mavlink.MAVLINK_MSG_ID_HOME_POSITION
RATES_HZ = {ATTITUDE: 50.0, HOME: 0.5}


class Streams:
    """A vehicle's side of the rates: what it was asked for and when; it answers with `result`."""

    def __init__(self, vehicle: FakeVehicle) -> None:
        self.asked: list[tuple[float, int]] = []
        self.result = mavlink.MAV_RESULT_ACCEPTED
        vehicle.script[Command] = self._answer

    def _answer(self, command: mavlink.MAVLink_command_long_message) -> Iterable[Message]:
        self.asked.append((clock.now(), int(command.param1)))
        yield mavlink.MAVLink_command_ack_message(command.command, self.result)

    def take(self) -> Counter[int]:
        """What it was asked for since the last call."""
        asked, self.asked = Counter(message_id for _, message_id in self.asked), []
        return asked


async def begun(connection: Connection, at_times: Container[int] = ()) -> MessageRates:
    rates = MessageRates(connection, RATES_HZ, at_times)
    await rates.ask()
    connection.spawn(rates.keep())
    return rates


async def send_attitudes(vehicle: FakeVehicle, duration_s: float, rate_hz: float = 25.0) -> None:
    for _ in range(round(duration_s * rate_hz)):
        vehicle.say(mavlink.MAVLink_attitude_message(1, 0, 0, 0, 0, 0, 0))
        await asyncio.sleep(1.0 / rate_hz)


@in_virtual_time
async def test_what_stays_away_is_asked_for_again_less_and_less_often() -> None:
    vehicle = FakeVehicle()
    streams = Streams(vehicle)
    async with connect_over(vehicle.open) as connection:
        await begun(connection)
        assert streams.take() == {ATTITUDE: 1, HOME: 1}
        await send_attitudes(vehicle, 100.0)
        times = [time_s for time_s, _ in streams.asked]
        assert streams.take().keys() == {HOME}
        assert 4 <= len(times) <= 8
        assert times[-1] - times[-2] > 20.0


@in_virtual_time
async def test_what_comes_at_times_is_asked_for_at_each_start_and_not_missed() -> None:
    vehicle = FakeVehicle()
    streams = Streams(vehicle)
    async with connect_over(vehicle.open) as connection:
        rates = await begun(connection, {HOME})
        assert streams.take() == {ATTITUDE: 1, HOME: 1}
        await send_attitudes(vehicle, 30.0)
        assert HOME not in streams.take()
        rates.ask_again()
        await send_attitudes(vehicle, 1.0)
        assert streams.take()[HOME] == 1


@in_virtual_time
async def test_a_rate_that_a_ground_station_lowered_is_asked_for_again_each_time_and_soon() -> None:
    vehicle = FakeVehicle()
    streams = Streams(vehicle)
    async with connect_over(vehicle.open) as connection:
        await begun(connection)
        streams.take()
        for _ in range(4):  # all the while the home position never comes
            await send_attitudes(vehicle, 15.0)
            assert ATTITUDE not in streams.take()
            await send_attitudes(vehicle, 6.5, rate_hz=4.0)
            assert streams.take()[ATTITUDE] in (1, 2)


@in_virtual_time
async def test_what_was_refused_is_not_asked_for_again_before_the_next_start() -> None:
    vehicle = FakeVehicle()
    streams = Streams(vehicle)
    streams.result = mavlink.MAV_RESULT_DENIED
    async with connect_over(vehicle.open) as connection:
        rates = await begun(connection)
        streams.take()
        await asyncio.sleep(60.0)
        assert not streams.take()
        rates.ask_again()
        await asyncio.sleep(2.0)
        assert streams.take() == {ATTITUDE: 1, HOME: 1}


@in_virtual_time
async def test_all_is_asked_for_again_when_the_vehicle_is_back_and_nothing_while_it_is_lost() -> None:
    vehicle = FakeVehicle(heartbeats=2)
    streams = Streams(vehicle)
    async with connect_over(vehicle.open) as connection:
        await begun(connection)
        answer = vehicle.script.pop(Command)
        await asyncio.sleep(20.0)
        sent = len(vehicle.heard_of(Command))
        await asyncio.sleep(60.0)
        assert connection.lost
        assert len(vehicle.heard_of(Command)) == sent
        vehicle.script[Command] = answer
        streams.take()
        await send_attitudes(vehicle, 3.0)
        assert streams.take() == {ATTITUDE: 1, HOME: 1}


@in_virtual_time
async def test_a_restart_that_takes_less_than_losing_the_link_is_seen_by_the_vehicles_time() -> None:
    vehicle = FakeVehicle()
    streams = Streams(vehicle)
    async with connect_over(vehicle.open) as connection:
        telemetry = await start_telemetry(connection)
        wishes = streams.take()
        for time_ms in (500_000, 500_100, 12_000, 12_100):
            vehicle.say(mavlink.MAVLink_attitude_message(time_ms, 0, 0, 0, 0, 0, 0))
            vehicle.say(mavlink.MAVLink_local_position_ned_message(time_ms, 0, 0, 0, 0, 0, 0))
            await asyncio.sleep(0.1)
        await asyncio.sleep(0.5)
        assert telemetry.restarts == 1
        assert streams.take() == wishes


@in_virtual_time
async def test_a_vehicle_that_answers_no_commands_any_more_ends_nothing() -> None:
    vehicle = FakeVehicle()
    Streams(vehicle)
    async with connect_over(vehicle.open) as connection:
        await begun(connection)
        del vehicle.script[Command]
        await asyncio.sleep(30.0)
        streams = Streams(vehicle)
        await asyncio.sleep(40.0)
        assert streams.take().keys() == RATES_HZ.keys()
