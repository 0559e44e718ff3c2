"""TCP: connect to a vehicle's server, or serve a vehicle that connects."""

import asyncio

from companion.link.address import TcpIn, TcpOut
from companion.link.os_errors import explained
from companion.link.stream import StreamTransport
from companion.link.transport import Receiver, Transport

_CONNECT_TIMEOUT_S = 5.0


async def open_tcp(address: TcpIn | TcpOut, receiver: Receiver) -> Transport:
    """A stream to `address`, or a server on it.

    Raises:
        LinkError: nothing listens there, the host is unknown, the port is taken, permission denied.
    """
    loop = asyncio.get_running_loop()
    what = f"TCP {address.host}:{address.port}"
    with explained(what):
        if isinstance(address, TcpOut):
            async with asyncio.timeout(_CONNECT_TIMEOUT_S):
                _, stream = await loop.create_connection(
                    lambda: StreamTransport(receiver, what), address.host, address.port
                )
            return stream
        server = TcpServerTransport(receiver, what)
        await server.listen(address.host, address.port)
        return server


class TcpServerTransport:
    """A TCP server as a `Transport`: its peer is whoever connected last; who leaves may come back."""

    def __init__(self, receiver: Receiver, what: str) -> None:
        self._receiver = receiver
        self._what = what
        self._client: StreamTransport | None = None
        self._dropped_before = 0

    async def listen(self, host: str, port: int) -> None:
        """Start to serve."""
        self._server = await asyncio.get_running_loop().create_server(self._welcome, host, port)

    @property
    def dropped(self) -> int:
        """Frames that no client took."""
        return self._dropped_before + (self._client.dropped if self._client else 0)

    def send(self, data: bytes) -> None:
        """Send one frame, or drop it."""
        if self._client is None:
            self._dropped_before += 1
        else:
            self._client.send(data)

    def answer_sender(self) -> None:
        """Nothing to do: there is one peer at a time."""

    async def aclose(self) -> None:
        """Stop serving, and close the client's stream."""
        self._server.close()
        if self._client is not None:
            await self._client.aclose()
        await self._server.wait_closed()

    def bytes_received(self, data: bytes) -> None:
        """The client sent something."""
        self._receiver.bytes_received(data)

    def transport_lost(self, error: Exception) -> None:
        """The client left; the next one is welcome."""

    def _welcome(self) -> StreamTransport:
        former, self._client = self._client, StreamTransport(self, self._what)
        if former is not None:
            self._dropped_before += former.dropped
            former.abort()
        return self._client
