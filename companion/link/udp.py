"""UDP: listen for a vehicle, or send to one."""

import asyncio
from typing import Any, cast

from companion.errors import LinkError
from companion.link.address import UdpIn, UdpOut
from companion.link.os_errors import explained
from companion.link.transport import Receiver

_LARGEST_BACKLOG = 4096
"""Bytes that may wait in this process when the network takes none; behind that, frames are dropped."""


async def open_udp(address: UdpIn | UdpOut, receiver: Receiver) -> "UdpTransport":
    """A socket bound to `address`, or connected to it.

    Raises:
        LinkError: the port is taken, the host unknown, permission denied.
    """
    place = (address.host, address.port)
    ends: dict[str, Any] = {"local_addr" if isinstance(address, UdpIn) else "remote_addr": place}
    with explained(f"UDP {address.host}:{address.port}"):
        _, protocol = await asyncio.get_running_loop().create_datagram_endpoint(
            lambda: UdpTransport(receiver, peer_known=isinstance(address, UdpOut)), **ends
        )
    return protocol


class UdpTransport(asyncio.DatagramProtocol):
    """A UDP socket as a `Transport`; made by `open_udp`.

    A listening socket sends nothing until it knows its peer: whoever last spoke for the vehicle.
    """

    def __init__(self, receiver: Receiver, *, peer_known: bool) -> None:
        self.dropped = 0
        self._receiver = receiver
        self._peer_known = peer_known
        self._peer: Any = None  # stays None on a connected socket, as sendto() wants it
        self._sender: Any = None
        self._listening = not peer_known
        self._closed = asyncio.get_running_loop().create_future()

    def send(self, data: bytes) -> None:
        """Send one datagram, or drop it."""
        # The typeshed does not know that selector loops tell a datagram transport's backlog too.
        backlog = self._socket.get_write_buffer_size()  # type: ignore[attr-defined]
        if not self._peer_known or backlog > _LARGEST_BACKLOG:
            self.dropped += 1
        else:
            self._socket.sendto(data, self._peer)

    def answer_sender(self) -> None:
        """Send to whoever sent the datagram that is being received."""
        if self._listening:
            self._peer, self._peer_known = self._sender, True

    async def aclose(self) -> None:
        """Close the socket."""
        self._socket.abort()
        await self._closed

    def connection_made(self, transport: asyncio.BaseTransport) -> None:  # noqa: D102
        self._socket = cast(asyncio.DatagramTransport, transport)

    def datagram_received(self, data: bytes, addr: Any) -> None:  # noqa: D102
        self._sender = addr
        self._receiver.bytes_received(data)

    def error_received(self, exc: Exception) -> None:
        """A datagram did not arrive: the vehicle may not be there yet, or no longer; heartbeats will tell."""
        self.dropped += 1

    def connection_lost(self, exc: Exception | None) -> None:  # noqa: D102
        self._closed.set_result(None)
        if exc is not None:
            self._receiver.transport_lost(LinkError(f"the UDP link was lost: {exc}"))
