"""Links that break, vehicles that fall silent, and how both come back."""

import asyncio
import os
import pty
import socket
import tty
from collections.abc import Callable
from contextlib import closing
from pathlib import Path

import pytest
from fake_vehicle import FakeVehicle, encoder, heartbeat, in_virtual_time

from companion import clock
from companion.errors import LinkError
from companion.link.connecting import connect
from companion.link.connection import Connection, connect_over
from companion.link.dialect import mavlink
from companion.link.presence import LOST_AFTER_S, LinkChange
from companion.link.transport import Receiver, Transport

HOST = "127.0.0.1"
BEAT = heartbeat().pack(encoder(4))


@in_virtual_time
async def test_who_asked_is_told_when_the_vehicle_falls_silent_and_when_it_is_back() -> None:
    vehicle = FakeVehicle(heartbeats=2)  # at 0.1 s and 1.1 s
    async with connect_over(vehicle.open) as connection:
        changes: list[LinkChange] = []
        leave = connection.presence.subscribe(changes.append)
        asyncio.get_running_loop().call_later(60.0, vehicle.say, heartbeat())
        await asyncio.sleep(61.0)
        assert [change.lost for change in changes] == [True, False]
        assert changes[0].time_s == pytest.approx(1.1 + LOST_AFTER_S)
        assert changes[0].silence_s == pytest.approx(LOST_AFTER_S)
        assert changes[1].silence_s == pytest.approx(changes[1].time_s - 1.1)
        assert connection.presence.losses == 1
        leave()
        await asyncio.sleep(10.0)
        assert connection.lost
        assert len(changes) == 2


@in_virtual_time
async def test_any_frame_of_the_vehicle_is_a_sign_of_life_and_none_of_another_is() -> None:
    vehicle = FakeVehicle(heartbeats=1)
    async with connect_over(vehicle.open) as connection:
        for _ in range(10):
            vehicle.say(mavlink.MAVLink_extended_sys_state_message(0, 1))
            await asyncio.sleep(1.0)
        assert not connection.lost
        assert connection.presence.silence_s == pytest.approx(1.0)
        for _ in range(10):
            vehicle.say(heartbeat(), system_id=9)
            await asyncio.sleep(1.0)
        assert connection.lost


class Cable:
    """Opens the fake vehicle's transport, unless it is unplugged."""

    def __init__(self, vehicle: FakeVehicle) -> None:
        self.vehicle = vehicle
        self.plugged = True
        self.tries_s: list[float] = []

    async def open(self, receiver: Receiver) -> Transport:
        self.tries_s.append(clock.now())
        if not self.plugged:
            raise LinkError("there is no such device")
        self.receiver = receiver
        return await self.vehicle.open(receiver)

    def pull(self) -> None:
        self.plugged = False
        self.receiver.transport_lost(LinkError("pulled"))


@in_virtual_time
async def test_what_breaks_is_opened_again_without_haste() -> None:
    cable = Cable(FakeVehicle())
    async with connect_over(cable.open) as connection:
        before = connection.transport
        cable.pull()
        await asyncio.sleep(60.0)
        assert connection.lost
        pauses = [later - sooner for sooner, later in zip(cable.tries_s, cable.tries_s[1:], strict=False)]
        assert pauses[-1] == pytest.approx(2.0)
        assert len(pauses) < 40
        cable.plugged = True
        await asyncio.sleep(4.0)
        assert connection.presence.silence_s <= 1.0
        assert connection.transport is not before


@in_virtual_time
async def test_what_cannot_be_opened_the_first_time_is_told_at_once() -> None:
    cable = Cable(FakeVehicle())
    cable.plugged = False
    with pytest.raises(LinkError, match="no such device"):
        async with connect_over(cable.open):
            pytest.fail("there is no such device")
    assert len(cable.tries_s) == 1


@in_virtual_time
async def test_a_failure_that_is_not_of_the_link_ends_the_connection() -> None:
    cable = Cable(FakeVehicle())

    async def use() -> None:
        async with connect_over(cable.open):
            cable.receiver.transport_lost(ZeroDivisionError())
            await asyncio.sleep(60.0)

    with pytest.raises(ZeroDivisionError):
        await use()
    assert clock.now() < 1.0


async def until(condition: Callable[[], bool]) -> None:
    for _ in range(2000):
        if condition():
            return
        await asyncio.sleep(0.01)
    pytest.fail("it did not happen")


async def opened_again_and_heard(connection: Connection, broken: Transport) -> None:
    await until(lambda: connection.transport is not broken and connection.presence.silence_s < 0.1)


@pytest.mark.realtime
async def test_a_tcp_server_that_restarts_is_found_again() -> None:
    async def serve(reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        with closing(writer):
            while not hang_up.is_set():
                writer.write(BEAT)
                await asyncio.sleep(0.02)

    hang_up = asyncio.Event()
    server = await asyncio.start_server(serve, HOST, 0)
    port = server.sockets[0].getsockname()[1]
    async with connect(f"tcpout://{HOST}:{port}") as connection:
        broken = connection.transport
        server.close()
        hang_up.set()
        await asyncio.sleep(0.5)
        hang_up.clear()
        server = await asyncio.start_server(serve, HOST, port)
        await opened_again_and_heard(connection, broken)
        assert connection.system_id == 4
    hang_up.set()
    server.close()
    await server.wait_closed()


@pytest.mark.realtime
async def test_a_serial_cable_that_is_pulled_is_found_again(tmp_path: Path) -> None:
    device = tmp_path / "ttyUSB0"

    def plug() -> tuple[int, int]:
        vehicle, port = pty.openpty()
        tty.setraw(vehicle)
        device.unlink(missing_ok=True)
        device.symlink_to(os.ttyname(port))
        return vehicle, port

    def pull(ends: tuple[int, int]) -> None:
        device.unlink()
        for end in ends:
            os.close(end)

    async def speak() -> None:
        while True:
            if ends:
                os.write(ends[0][0], BEAT)
            await asyncio.sleep(0.02)

    ends = [plug()]
    speaking = asyncio.create_task(speak())
    async with connect(f"serial://{device}:57600") as connection:
        broken = connection.transport
        pull(ends.pop())
        await asyncio.sleep(0.5)
        ends.append(plug())
        await opened_again_and_heard(connection, broken)
        assert connection.system_id == 4
    speaking.cancel()
    pull(ends.pop())


@pytest.mark.realtime
async def test_a_vehicle_that_closes_its_udp_port_for_a_while_is_heard_again() -> None:
    def plug(port: int = 0) -> socket.socket:
        vehicle = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        vehicle.bind((HOST, port))
        return vehicle

    vehicle = plug()
    port = vehicle.getsockname()[1]

    async def answer() -> None:
        """Heartbeat to whoever sent something."""
        loop = asyncio.get_running_loop()
        vehicle.setblocking(False)
        while True:
            _, sender = await loop.sock_recvfrom(vehicle, 2048)
            vehicle.sendto(BEAT, sender)

    answering = asyncio.create_task(answer())
    async with connect(f"udpout://{HOST}:{port}") as connection:
        answering.cancel()
        await asyncio.wait([answering])
        vehicle.close()
        refused = connection.transport.dropped
        await until(lambda: connection.transport.dropped > refused)  # our heartbeats: ECONNREFUSED
        vehicle = plug(port)
        answering = asyncio.create_task(answer())
        await until(lambda: connection.presence.silence_s < 0.1)
        assert not connection.lost
    answering.cancel()
    await asyncio.wait([answering])
    vehicle.close()
