import asyncio
import math
import socket
from collections.abc import AsyncIterator, Callable
from contextlib import asynccontextmanager
from typing import Any, Literal

import numpy as np
import pytest
from mavlink_fakes import ARDUCOPTER, command_long, encode, fake_vehicle, parse
from pymavlink import mavutil
from pymavlink.dialects.v20 import common as mavlink
from sitl_flights import hover

from sitl.endpoints import Endpoint, TcpEndpoint, ardupilot_endpoints, px4_endpoints
from sitl.errors import ServeError
from sitl.firmware.interface import Mode, Severity, StatusText
from sitl.mavlink import GROUND_STATION, OFFBOARD, Delivery, MavlinkVehicle, open_vehicle
from sitl.mavlink.links import SERIAL_0
from sitl.server import Pace, Served, serve

SPEED = 20.0
PATIENCE_S = 30.0


def quiet(line: str) -> None: ...


@asynccontextmanager
async def served(
    vehicle: MavlinkVehicle, *endpoints: Endpoint | TcpEndpoint, say: Callable[[str], None] = quiet
) -> AsyncIterator[None]:
    async with asyncio.timeout(PATIENCE_S), asyncio.TaskGroup() as group:
        serving = group.create_task(serve([Served(vehicle, endpoints)], speed=SPEED, say=say))
        yield
        serving.cancel()


class Peer(asyncio.DatagramProtocol):
    """A client's socket: keeps what arrived."""

    def __init__(self) -> None:
        self.received: asyncio.Queue[Any] = asyncio.Queue()

    def connection_made(self, transport: Any) -> None:
        self.transport = transport
        self.address = transport.get_extra_info("sockname")

    def datagram_received(self, data: bytes, address: tuple[str, int]) -> None:
        self.vehicle_address = address
        for message in parse([Delivery(0.0, OFFBOARD, data)]):
            self.received.put_nowait(message)

    async def next(self, name: str) -> Any:
        while (message := await self.received.get()).get_type() != name:
            pass
        return message


@asynccontextmanager
async def peer() -> AsyncIterator[Peer]:
    loop = asyncio.get_running_loop()
    transport, protocol = await loop.create_datagram_endpoint(Peer, local_addr=("127.0.0.1", 0))
    try:
        yield protocol
    finally:
        transport.close()


def arm_and_take_off(connection: Any) -> float:
    """What a user's script does with pymavlink; the highest altitude reached (m)."""
    heartbeat = connection.wait_heartbeat(timeout=PATIENCE_S)
    assert heartbeat.autopilot == mavlink.MAV_AUTOPILOT_PX4
    nan = math.nan
    for command, params in (
        (mavlink.MAV_CMD_COMPONENT_ARM_DISARM, [1, 0, 0, 0, 0, 0, 0]),
        (mavlink.MAV_CMD_NAV_TAKEOFF, [0, 0, 0, nan, nan, nan, nan]),
    ):
        connection.mav.command_long_send(1, 1, command, 0, *params)
        answer = connection.recv_match(type="COMMAND_ACK", blocking=True, timeout=PATIENCE_S)
        assert (answer.command, answer.result) == (command, mavlink.MAV_RESULT_ACCEPTED)
    height_m = 0.0
    while height_m < 1.0:
        position = connection.recv_match(type="LOCAL_POSITION_NED", blocking=True, timeout=PATIENCE_S)
        height_m = -position.z
    return height_m


@pytest.mark.realtime
async def test_a_pymavlink_client_arms_and_takes_off() -> None:
    open_vehicle("bebop2").advance(0.01)  # compiled before anybody waits
    vehicle = open_vehicle("bebop2")
    connection: Any = mavutil.mavlink_connection("udpin:127.0.0.1:0", source_system=245)
    try:
        async with served(vehicle, Endpoint(OFFBOARD, 0, connection.port.getsockname())):
            assert await asyncio.to_thread(arm_and_take_off, connection) > 1.0
    finally:
        connection.close()
    assert vehicle.simulation.firmware.armed


async def test_each_link_serves_its_peer() -> None:
    vehicle, _ = fake_vehicle(links=(OFFBOARD, GROUND_STATION))
    async with peer() as companion, peer() as ground:
        endpoints = (Endpoint(OFFBOARD, 0, companion.address), Endpoint(GROUND_STATION, 0, ground.address))
        async with served(vehicle, *endpoints):
            await companion.next("TIMESYNC")
            await ground.next("HEARTBEAT")
            ground.transport.sendto(encode(command_long(mavlink.MAV_CMD_NAV_LAND)), ground.vehicle_address)
            assert (await ground.next("COMMAND_ACK")).command == mavlink.MAV_CMD_NAV_LAND


async def test_whoever_speaks_is_answered() -> None:
    vehicle, _ = fake_vehicle()
    async with (
        peer() as companion,
        peer() as stranger,
        served(vehicle, Endpoint(OFFBOARD, 0, companion.address)),
    ):
        await companion.next("HEARTBEAT")
        stranger.transport.sendto(b"\xfd\xff rubbish", companion.vehicle_address)
        for listener in (stranger, companion):
            assert (await listener.next("HEARTBEAT")).get_srcSystem() == vehicle.system_id


async def test_the_watcher_reads_modes_and_texts() -> None:
    vehicle, firmware = fake_vehicle()
    lines: list[str] = []
    seen = asyncio.Event()

    def say(line: str) -> None:
        lines.append(line)
        if "mode" in line:
            seen.set()

    async with peer() as companion, served(vehicle, Endpoint(OFFBOARD, 0, companion.address), say=say):
        await companion.next("HEARTBEAT")
        firmware.texts = [StatusText(Severity.WARNING, "Low battery")]
        await companion.next("STATUSTEXT")
        firmware.mode, firmware.armed = Mode.LAND, True
        await seen.wait()
    assert [line.split("  ")[-1] for line in lines] == ["warning: Low battery", "mode LAND, armed"]


async def test_a_taken_port_is_one_clear_error_and_leaves_nothing_open() -> None:
    vehicle, _ = fake_vehicle(links=(OFFBOARD, GROUND_STATION))
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as taken:
        taken.bind(("127.0.0.1", 0))
        port = taken.getsockname()[1]
        elsewhere = ("127.0.0.1", 9)
        endpoints = (Endpoint(OFFBOARD, 0, elsewhere), Endpoint(GROUND_STATION, port, elsewhere))
        with pytest.raises(ServeError, match=f"UDP port {port} for the ground station link"):
            await serve([Served(vehicle, endpoints)], say=quiet)


async def test_an_unknown_machine_is_named() -> None:
    vehicle, _ = fake_vehicle()
    with pytest.raises(ServeError, match=r"no\.such\.machine\.invalid"):
        await serve([Served(vehicle, [Endpoint(OFFBOARD, 0, ("no.such.machine.invalid", 1))])], say=quiet)


def test_ports_are_px4s() -> None:
    offboard, ground = px4_endpoints(3)
    assert (offboard.port, offboard.peer) == (14582, ("127.0.0.1", 14542))
    assert (ground.port, ground.peer) == (18572, ("127.0.0.1", 14550))


def test_only_a_peer_elsewhere_opens_the_vehicle_to_the_network() -> None:
    assert px4_endpoints()[0].host == "127.0.0.1"
    assert px4_endpoints(peer_host="192.168.1.5")[0].host == "0.0.0.0"


def test_a_machine_that_keeps_up_follows_the_clock() -> None:
    clock = [100.0]
    pace = Pace(lambda: clock[0], speed=5.0, say=pytest.fail)
    clock[0] += 20.0
    assert pace.simulation_time(reached_s=99.9) == pytest.approx(100.0)


def test_a_machine_that_is_too_slow_says_so_and_does_not_hurry_after() -> None:
    clock, reached_s, lines = [0.0], 0.0, list[str]()
    pace = Pace(lambda: clock[0], speed=5.0, say=lines.append)
    for _ in range(400):  # manages 2 simulated seconds a second
        clock[0] += 0.05
        target_s = pace.simulation_time(reached_s)
        assert target_s - reached_s <= 5.0 * 0.3
        reached_s = min(target_s, reached_s + 0.1)
    assert reached_s == pytest.approx(40.0, abs=2.0)
    assert [line[: -len(".0 times real time")] for line in lines] == [
        "this machine cannot keep up: runs at 2"
    ] * 2


def test_ardupilots_link_goes_where_its_own_simulator_sends() -> None:
    endpoint, *serial = ardupilot_endpoints(3)
    assert isinstance(endpoint, Endpoint)
    assert (endpoint.port, endpoint.peer) == (0, ("127.0.0.1", 14570))
    assert [each.port for each in serial] == [5780, 5782, 5783]
    assert ardupilot_endpoints(peer_host="192.168.1.5")[0].host == "0.0.0.0"


async def test_everyone_who_speaks_goes_on_being_served() -> None:
    vehicle, _ = fake_vehicle()
    async with (
        peer() as companion,
        peer() as second,
        peer() as third,
        served(vehicle, Endpoint(OFFBOARD, 0, companion.address)),
    ):
        await companion.next("HEARTBEAT")
        for speaker in (second, third):
            speaker.transport.sendto(b"here", companion.vehicle_address)
            await speaker.next("HEARTBEAT")
        for listener in (companion, second, third):
            listener.received = asyncio.Queue()
            assert (await listener.next("HEARTBEAT")).get_srcSystem() == vehicle.system_id


async def connected(port: int) -> tuple[asyncio.StreamReader, asyncio.StreamWriter]:
    """A connection, as soon as somebody listens."""
    while True:
        try:
            return await asyncio.open_connection("127.0.0.1", port)
        except ConnectionRefusedError:
            await asyncio.sleep(0)


@pytest.mark.realtime
async def test_a_client_over_tcp_is_served_though_its_frames_come_in_pieces() -> None:
    vehicle, _ = fake_vehicle(vehicle=ARDUCOPTER, links=(SERIAL_0,))
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        port = int(free.getsockname()[1])
    async with served(vehicle, TcpEndpoint(SERIAL_0, port)):
        reader, writer = await connected(port)
        try:
            for byte in encode(command_long(mavlink.MAV_CMD_NAV_LAND)):
                writer.write(bytes([byte]))
                await writer.drain()
            parser = mavlink.MAVLink(None)
            heard: dict[str, Any] = {}
            while not {"HEARTBEAT", "COMMAND_ACK"} <= heard.keys():
                messages = parser.parse_buffer(await reader.read(1024)) or []
                heard |= {message.get_type(): message for message in messages}
            assert heard["COMMAND_ACK"].command == mavlink.MAV_CMD_NAV_LAND
        finally:
            writer.close()


@pytest.mark.realtime
async def test_no_more_clients_than_eight_are_served_over_tcp() -> None:
    vehicle, _ = fake_vehicle(vehicle=ARDUCOPTER, links=(SERIAL_0,))
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        port = int(free.getsockname()[1])
    async with asyncio.timeout(PATIENCE_S), served(vehicle, TcpEndpoint(SERIAL_0, port)):
        clients = [await connected(port) for _ in range(9)]
        *served_ones, ninth = [reader for reader, _ in clients]
        with pytest.raises((ConnectionResetError, asyncio.IncompleteReadError)):
            await ninth.readexactly(1)
        for reader in served_ones:
            assert await reader.readexactly(1)
        for _, writer in clients:
            writer.close()


@pytest.mark.realtime
async def test_vehicles_of_a_fleet_fly_together_and_apart() -> None:
    async with peer() as ground:
        fleet = []
        for number in (1, 2, 3):
            vehicle = open_vehicle("bebop2", system_id=number, start=(0.0, 3.0 * number))
            fleet.append(Served(vehicle, [Endpoint(OFFBOARD, 0, ground.address)]))
        places: dict[int, float] = {}
        async with asyncio.timeout(PATIENCE_S), asyncio.TaskGroup() as group:
            serving = group.create_task(serve(fleet, say=quiet))
            while len(places) < 3:
                message = await ground.next("LOCAL_POSITION_NED")
                places[message.get_srcSystem()] = message.y
            serving.cancel()
    assert places == pytest.approx({1: 3.0, 2: 6.0, 3: 9.0}, abs=0.1)
    assert len({each.vehicle.simulation.time_s for each in fleet}) == 1


@pytest.mark.parametrize(("name", "autopilot"), [("bebop2", "ardupilot"), ("arducopter_sitl", "px4")])
def test_a_vehicle_flies_with_the_other_autopilot_and_from_elsewhere(
    name: str, autopilot: Literal["px4", "ardupilot"]
) -> None:
    sim = open_vehicle(name, autopilot=autopilot, start=(0.0, 6.0), record_truth=True).simulation
    hover(sim)
    settled = [truth.position for truth in sim.truth_log[-300:]]
    np.testing.assert_allclose(settled, [(0.0, 6.0, -2.5)] * 300, atol=0.1)
