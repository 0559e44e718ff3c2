"""A ground station behind us on the vehicle's link, as with mavlink-router.

Frames pass as they are, signatures included, whether or not we believe them: that is for their receiver to
judge. A ground station that does not read misses frames; nothing waits for it.
"""

import asyncio
from collections.abc import AsyncIterator
from contextlib import aclosing, asynccontextmanager

from companion.link.connection import Connection
from companion.link.dialect import mavlink
from companion.link.framing import FrameSplitter
from companion.link.lasting import LastingTransport, OpenTransport, open_lasting

_SETUP_SIGNING = mavlink.MAVLINK_MSG_ID_SETUP_SIGNING.to_bytes(3, "little")


@asynccontextmanager
async def forwarding(connection: Connection, opener: OpenTransport) -> AsyncIterator[None]:
    """Pass frames between the connection's link and the transport that `opener` opens, until the block ends.

    Raises:
        LinkError: it cannot be opened.
    """
    ground = _Ground(connection)
    transport = ground.transport = await open_lasting(opener, ground)
    async with aclosing(transport):
        reopening = connection.spawn(transport.keep_open())
        leave = connection.overhear(ground.tell)
        try:
            yield
        finally:
            leave()
            reopening.cancel()
            await asyncio.wait([reopening])


class _Ground:
    """Where the ground station's bytes arrive, and where those for it go."""

    transport: LastingTransport

    def __init__(self, connection: Connection) -> None:
        self._connection = connection
        self._splitter = FrameSplitter()

    def tell(self, data: bytes) -> None:
        if _may_pass(data):
            self.transport.send(data)

    def bytes_received(self, data: bytes) -> None:
        for frame in self._splitter.feed(data):
            self.transport.answer_sender()
            if _may_pass(frame.data):
                self._connection.relay(frame)

    def transport_lost(self, error: Exception) -> None:
        self._connection.transport_lost(error)


def _may_pass(data: bytes) -> bool:
    """All frames but the one that carries a signing key, which must not leave the link it was sent on."""
    return data[0] != mavlink.PROTOCOL_MARKER_V2 or data[7:10] != _SETUP_SIGNING
