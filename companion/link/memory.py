"""Two ends in one process: the transport for scripted vehicles and tests."""

import asyncio
from collections.abc import Callable

from companion.link.transport import Receiver


class MemoryTransport:
    """The companion's end; `far_end` is called with each frame that the companion sends.

    Bytes take one turn of the event loop in either direction, as over a real link: no answer comes before
    the question is out.
    """

    def __init__(self, receiver: Receiver, far_end: Callable[[bytes], None]) -> None:
        self.dropped = 0
        self._receiver = receiver
        self._far_end = far_end
        self._open = True
        self._loop = asyncio.get_running_loop()

    def send(self, data: bytes) -> None:
        """Send one frame."""
        self._loop.call_soon(self._far_end, data)

    def deliver(self, data: bytes) -> None:
        """Send bytes from the far end."""
        self._loop.call_soon(self._receive, data)

    def answer_sender(self) -> None:
        """Nothing to do: there is one peer."""

    async def aclose(self) -> None:
        """Close it: what is under way arrives no more."""
        self._open = False

    def _receive(self, data: bytes) -> None:
        if self._open:
            self._receiver.bytes_received(data)
