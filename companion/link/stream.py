"""What TCP and serial ports share: a stream of bytes to one peer, with a bounded backlog."""

import asyncio

from companion.errors import LinkError
from companion.link.transport import Receiver

_LARGEST_BACKLOG = 4096
"""Bytes that may wait in this process when the peer does not read; behind that, frames are dropped."""


class StreamTransport(asyncio.Protocol):
    """An asyncio stream as a `Transport`: to be handed to what opens the stream, as its protocol."""

    def __init__(self, receiver: Receiver, what: str) -> None:
        self.dropped = 0
        self._receiver = receiver
        self._what = what
        self._stream: asyncio.Transport | None = None
        self._closing = False
        self._closed = asyncio.get_running_loop().create_future()

    def send(self, data: bytes) -> None:
        """Send one frame, or drop it."""
        if self._stream is None or self._stream.get_write_buffer_size() > _LARGEST_BACKLOG:
            self.dropped += 1
        else:
            self._stream.write(data)

    def answer_sender(self) -> None:
        """Nothing to do: there is one peer."""

    def abort(self) -> None:
        """Close the stream at once; what still waits in it is lost."""
        self._closing = True
        if self._stream is not None:
            self._stream.abort()

    async def aclose(self) -> None:
        """Close the stream, and wait until it is closed."""
        self.abort()
        if self._stream is not None:
            await self._closed

    def connection_made(self, transport: asyncio.BaseTransport) -> None:  # noqa: D102
        assert isinstance(transport, asyncio.Transport)
        self._stream = transport

    def data_received(self, data: bytes) -> None:  # noqa: D102
        self._receiver.bytes_received(data)

    def connection_lost(self, exc: Exception | None) -> None:  # noqa: D102
        self._stream = None
        self._closed.set_result(None)
        if not self._closing:
            reason = exc or ConnectionResetError("the other side closed it")
            self._receiver.transport_lost(LinkError(f"{self._what}: {reason}"))
