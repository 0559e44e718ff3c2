"""The vehicle's links as sockets: bytes in from whoever speaks, frames out to whoever listens."""

import asyncio
from collections.abc import Callable
from dataclasses import replace
from socket import AF_INET
from typing import Protocol, cast

from sitl.endpoints import Address, Endpoint, TcpEndpoint
from sitl.errors import ServeError
from sitl.mavlink.frames import whole_frames

_MOST_SPEAKERS = 8
_MOST_WAITING_BYTES = 64 * 1024

Receive = Callable[[bytes], None]
"""Takes a datagram, or the whole frames of a stream."""


class Socket(Protocol):
    """An open endpoint."""

    def send(self, data: bytes) -> None:
        """Send a frame to every peer."""
        ...

    def close(self) -> None:
        """Take and send nothing more."""
        ...


class UdpSocket(asyncio.DatagramProtocol):
    """Sends to the peer that the endpoint names, and to those that spoke last."""

    def __init__(self, peer: Address, receive: Receive) -> None:
        self._peer = peer
        self._receive = receive
        self._speakers: dict[Address, None] = {}
        self._transport: asyncio.DatagramTransport | None = None

    def connection_made(self, transport: asyncio.BaseTransport) -> None:
        """Called by asyncio."""
        self._transport = cast("asyncio.DatagramTransport", transport)

    def datagram_received(self, data: bytes, address: Address) -> None:
        """Called by asyncio; the oldest speaker makes room for a new one."""
        if address != self._peer:
            self._speakers.pop(address, None)
            self._speakers[address] = None
            if len(self._speakers) > _MOST_SPEAKERS:
                del self._speakers[next(iter(self._speakers))]
        self._receive(data)

    def send(self, data: bytes) -> None:
        """Send a frame to every peer."""
        if self._transport is not None:
            for address in (self._peer, *self._speakers):
                self._transport.sendto(data, address)

    def close(self) -> None:
        """Take and send nothing more."""
        if self._transport is not None:
            self._transport.close()


class TcpSocket:
    """Sends to everyone who is connected; one who does not read loses the newest frames."""

    def __init__(self, receive: Receive) -> None:
        self._receive = receive
        self._connections: set[asyncio.Transport] = set()
        self._server: asyncio.Server | None = None

    async def open(self, host: str, port: int) -> None:
        """Listen.

        Raises:
            OSError: the port cannot be had.
        """
        loop = asyncio.get_running_loop()
        self._server = await loop.create_server(
            lambda: _Connection(self._receive, self._connections), host, port
        )

    @property
    def port(self) -> int:
        """Where it listens."""
        assert self._server is not None
        return int(self._server.sockets[0].getsockname()[1])

    def send(self, data: bytes) -> None:
        """Send a frame to every peer."""
        for connection in self._connections:
            if connection.get_write_buffer_size() < _MOST_WAITING_BYTES:
                connection.write(data)

    def close(self) -> None:
        """Take and send nothing more."""
        if self._server is not None:
            self._server.close()
        for connection in self._connections:
            connection.close()


class _Connection(asyncio.Protocol):
    """One peer of a `TcpSocket`."""

    def __init__(self, receive: Receive, connections: set[asyncio.Transport]) -> None:
        self._receive = receive
        self._connections = connections
        self._rest = b""

    def connection_made(self, transport: asyncio.BaseTransport) -> None:
        self._transport = cast("asyncio.Transport", transport)
        if len(self._connections) < _MOST_SPEAKERS:
            self._connections.add(self._transport)
        else:
            self._transport.abort()

    def data_received(self, data: bytes) -> None:
        self._rest += data
        length = whole_frames(self._rest)
        self._receive(self._rest[:length])
        self._rest = self._rest[length:]

    def connection_lost(self, exc: Exception | None) -> None:
        self._connections.discard(self._transport)


async def open_socket(endpoint: Endpoint | TcpEndpoint, receive: Receive) -> Socket:
    """Open an endpoint.

    Raises:
        ServeError: the port is in use, or the peer's name is unknown.
    """
    kind = "TCP" if isinstance(endpoint, TcpEndpoint) else "UDP"
    if isinstance(endpoint, Endpoint):
        endpoint = replace(endpoint, peer=await _resolved(endpoint.peer))
    try:
        return await _open(endpoint, receive)
    except OSError as error:
        raise ServeError(
            f"{kind} port {endpoint.port} for the {endpoint.link.name} link cannot be had "
            f"({error.strerror}); stop what uses it, or take another --system-id"
        ) from None


async def _open(endpoint: Endpoint | TcpEndpoint, receive: Receive) -> Socket:
    if isinstance(endpoint, TcpEndpoint):
        listening = TcpSocket(receive)
        await listening.open(endpoint.host, endpoint.port)
        return listening
    socket = UdpSocket(endpoint.peer, receive)
    loop = asyncio.get_running_loop()
    await loop.create_datagram_endpoint(lambda: socket, local_addr=(endpoint.host, endpoint.port))
    return socket


async def _resolved(peer: Address) -> Address:
    try:
        found = await asyncio.get_running_loop().getaddrinfo(*peer, family=AF_INET)
    except OSError as error:
        raise ServeError(f"no machine named {peer[0]} ({error.strerror})") from None
    return cast("Address", found[0][4])
