import asyncio
import os
import pty
import socket
import tty
from collections.abc import Callable, Iterator
from contextlib import closing
from pathlib import Path

import pytest
from fake_vehicle import encoder, heartbeat

from companion.errors import LinkError
from companion.link.address import Serial, TcpIn, TcpOut, UdpIn, UdpOut
from companion.link.connecting import connect
from companion.link.dialect import mavlink
from companion.link.opening import open_transport
from companion.link.stream import StreamTransport

HOST = "127.0.0.1"
TIMEOUT_S = 10.0


class Ears:
    """A receiver that remembers."""

    def __init__(self) -> None:
        self.data = b""
        self.lost: Exception | None = None
        self.changed = asyncio.Event()

    def bytes_received(self, data: bytes) -> None:
        self.data += data
        self.changed.set()

    def transport_lost(self, error: Exception) -> None:
        self.lost = error
        self.changed.set()

    async def until(self, condition: Callable[[], bool]) -> None:
        async with asyncio.timeout(TIMEOUT_S):
            while not condition():
                self.changed.clear()
                await self.changed.wait()


@pytest.fixture
def peer() -> Iterator[socket.socket]:
    """A UDP socket of somebody else."""
    with closing(socket.socket(socket.AF_INET, socket.SOCK_DGRAM)) as other:
        other.bind((HOST, 0))
        other.setblocking(False)
        yield other


def free_port(kind: socket.SocketKind) -> int:
    with closing(socket.socket(socket.AF_INET, kind)) as probe:
        probe.bind((HOST, 0))
        port: int = probe.getsockname()[1]
        return port


async def hear(other: socket.socket) -> bytes:
    async with asyncio.timeout(TIMEOUT_S):
        return await asyncio.get_running_loop().sock_recv(other, 2048)


async def test_udp_out_sends_and_hears(peer: socket.socket) -> None:
    ears = Ears()
    transport = await open_transport(UdpOut(HOST, peer.getsockname()[1]), ears)
    transport.send(b"hello")
    data, sender = await asyncio.get_running_loop().sock_recvfrom(peer, 100)
    assert data == b"hello"
    peer.sendto(b"answer", sender)
    await ears.until(lambda: ears.data == b"answer")
    await transport.aclose()
    assert ears.lost is None


async def test_udp_in_answers_whom_it_was_told_to_answer(peer: socket.socket) -> None:
    ears = Ears()
    port = free_port(socket.SOCK_DGRAM)
    transport = await open_transport(UdpIn(HOST, port), ears)
    transport.send(b"to nobody")
    assert transport.dropped == 1
    with closing(socket.socket(socket.AF_INET, socket.SOCK_DGRAM)) as stranger:
        peer.sendto(b"vehicle", (HOST, port))
        await ears.until(lambda: ears.data == b"vehicle")
        transport.answer_sender()
        stranger.sendto(b" stranger", (HOST, port))
        await ears.until(lambda: ears.data == b"vehicle stranger")
    transport.send(b"to the vehicle")
    assert await hear(peer) == b"to the vehicle"
    await transport.aclose()
    with closing(socket.socket(socket.AF_INET, socket.SOCK_DGRAM)) as again:
        again.bind((HOST, port))


async def test_two_vehicles_on_one_udp_port_each_get_their_own(peer: socket.socket) -> None:
    port = free_port(socket.SOCK_DGRAM)
    loop = asyncio.get_running_loop()
    with closing(socket.socket(socket.AF_INET, socket.SOCK_DGRAM)) as other:
        other.bind((HOST, 0))
        other.setblocking(False)

        async def both_speak() -> None:
            while True:
                other.sendto(heartbeat().pack(encoder(1)), (HOST, port))
                peer.sendto(heartbeat().pack(encoder(2)), (HOST, port))
                await asyncio.sleep(0.02)

        speaking = loop.create_task(both_speak())
        async with connect(UdpIn(HOST, port), system_id=2) as connection:
            assert connection.system_id == 2
            connection.send(mavlink.MAVLink_timesync_message(0, 1))
            assert len(await hear(peer)) > 0
            with pytest.raises(BlockingIOError):
                other.recv(2048)
        speaking.cancel()


async def test_an_udp_peer_that_is_not_there_yet_is_no_error(peer: socket.socket) -> None:
    ears = Ears()
    transport = await open_transport(UdpOut(HOST, free_port(socket.SOCK_DGRAM)), ears)
    for _ in range(3):
        transport.send(b"anybody?")
        await asyncio.sleep(0)
    await transport.aclose()
    assert ears.lost is None


async def test_a_taken_port_is_told(peer: socket.socket) -> None:
    with pytest.raises(LinkError, match="the port is taken"):
        await open_transport(UdpIn(HOST, peer.getsockname()[1]), Ears())
    with closing(socket.create_server((HOST, 0))) as server, pytest.raises(LinkError, match="port is taken"):
        await open_transport(TcpIn(HOST, server.getsockname()[1]), Ears())


async def test_an_unknown_host_is_told() -> None:
    with pytest.raises(LinkError, match=r"UDP nowhere\.invalid:14540: the host is unknown"):
        await open_transport(UdpOut("nowhere.invalid", 14540), Ears())


async def test_nothing_listening_is_told() -> None:
    with pytest.raises(LinkError, match="nothing listens there"):
        await open_transport(TcpOut(HOST, free_port(socket.SOCK_STREAM)), Ears())


async def test_tcp_out_sends_hears_and_tells_when_the_server_leaves() -> None:
    heard = Ears()

    async def serve(reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        heard.bytes_received(await reader.readexactly(5))
        writer.write(b"answer")
        await writer.drain()
        writer.close()
        await writer.wait_closed()

    server = await asyncio.start_server(serve, HOST, 0)
    async with server:
        ears = Ears()
        transport = await open_transport(TcpOut(HOST, server.sockets[0].getsockname()[1]), ears)
        transport.send(b"hello")
        await heard.until(lambda: heard.data == b"hello")
        await ears.until(lambda: ears.lost is not None)
        assert ears.data == b"answer"
        assert isinstance(ears.lost, LinkError)
        transport.send(b"too late")
        assert transport.dropped == 1
        await transport.aclose()


async def test_tcp_in_serves_one_client_after_another() -> None:
    ears = Ears()
    port = free_port(socket.SOCK_STREAM)
    transport = await open_transport(TcpIn(HOST, port), ears)
    transport.send(b"nobody there")
    assert transport.dropped == 1
    for name in (b"first", b"second"):
        reader, writer = await asyncio.open_connection(HOST, port)
        writer.write(name)
        await ears.until(lambda name=name: ears.data.endswith(name))  # type: ignore[misc]
        transport.send(b"hello " + name)
        assert await reader.readexactly(6 + len(name)) == b"hello " + name
        writer.close()
        await writer.wait_closed()
    await transport.aclose()
    assert ears.lost is None


async def test_frames_are_dropped_when_the_peer_does_not_read() -> None:
    with closing(socket.create_server((HOST, 0))) as server:
        transport = await open_transport(TcpOut(HOST, server.getsockname()[1]), Ears())
        assert isinstance(transport, StreamTransport)
        for _ in range(20_000):
            transport.send(bytes(280))
        assert transport.dropped > 0
        async with asyncio.timeout(TIMEOUT_S):
            await transport.aclose()


@pytest.fixture
def serial_port() -> Iterator[tuple[int, str]]:
    """The vehicle's end (a file descriptor) and the path of a serial port."""
    vehicle, port = pty.openpty()
    tty.setraw(vehicle)
    path = os.ttyname(port)
    yield vehicle, path
    os.close(port)
    os.close(vehicle)


async def test_serial_sends_and_hears(serial_port: tuple[int, str]) -> None:
    vehicle, path = serial_port
    ears = Ears()
    transport = await open_transport(Serial(path, 921600), ears)
    os.write(vehicle, b"telemetry")
    await ears.until(lambda: ears.data == b"telemetry")
    transport.send(b"setpoint")
    assert await asyncio.to_thread(os.read, vehicle, 100) == b"setpoint"
    async with asyncio.timeout(TIMEOUT_S):
        await transport.aclose()
    assert ears.lost is None


async def test_a_vehicle_on_a_serial_port(serial_port: tuple[int, str]) -> None:
    vehicle, path = serial_port

    async def speak() -> None:
        while True:
            os.write(vehicle, b"boot messages\r\n\xfd" + heartbeat().pack(encoder(4)))
            await asyncio.sleep(0.02)

    speaking = asyncio.create_task(speak())
    async with connect(f"serial://{path}:57600", timeout_s=TIMEOUT_S) as connection:
        assert connection.system_id == 4
    speaking.cancel()


async def test_a_serial_port_that_is_not_there_is_told(tmp_path: Path) -> None:
    with pytest.raises(LinkError, match="no such device"):
        await open_transport(Serial(str(tmp_path / "ttyNONE"), 57600), Ears())
