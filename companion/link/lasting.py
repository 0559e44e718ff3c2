"""A transport that outlives its cable: whatever breaks is opened again, as often as it takes."""

import asyncio
from collections.abc import Awaitable, Callable
from typing import TypeAlias

from companion.errors import LinkError
from companion.link.transport import Receiver, Transport

OpenTransport: TypeAlias = Callable[[Receiver], Awaitable[Transport]]

_FIRST_WAIT_S = 0.1
_LONGEST_WAIT_S = 2.0
_ATTEMPT_TIMEOUT_S = 10.0


class LastingTransport:
    """A `Transport` over those that `opener` opens, one after the other; made by `open_lasting`.

    A LinkError is what links do: the next transport is opened. Any other error is told to the receiver.

    Attributes:
        current: the newest, perhaps broken; frames that are sent while it is are dropped.
        breaks: how often one broke.
    """

    current: Transport

    def __init__(self, opener: OpenTransport, receiver: Receiver) -> None:
        self.breaks = 0
        self._opener = opener
        self._receiver = receiver
        self._broken = asyncio.Event()
        self._dropped_before = 0

    @property
    def dropped(self) -> int:
        """How many frames were not sent."""
        return self._dropped_before + self.current.dropped

    def send(self, data: bytes) -> None:
        """Send one frame, or drop it."""
        self.current.send(data)

    def answer_sender(self) -> None:
        """Send to whoever sent what is being received."""
        self.current.answer_sender()

    async def aclose(self) -> None:
        """Close it for good."""
        await self.current.aclose()

    async def keep_open(self) -> None:
        """Open what broke anew, until cancelled."""
        while True:
            await self._broken.wait()
            self._broken.clear()
            broken = self.current
            await broken.aclose()
            self.current = await self._reopened()
            self._dropped_before += broken.dropped

    def bytes_received(self, data: bytes) -> None:
        """Hand on what arrived."""
        self._receiver.bytes_received(data)

    def transport_lost(self, error: Exception) -> None:
        """The transport broke."""
        if isinstance(error, LinkError):
            self.breaks += 1
            self._broken.set()
        else:
            self._receiver.transport_lost(error)

    async def _reopened(self) -> Transport:
        wait_s = _FIRST_WAIT_S
        while True:
            await asyncio.sleep(wait_s)
            wait_s = min(2.0 * wait_s, _LONGEST_WAIT_S)
            try:
                async with asyncio.timeout(_ATTEMPT_TIMEOUT_S):
                    return await self._opener(self)
            except (LinkError, TimeoutError):
                continue


async def open_lasting(opener: OpenTransport, receiver: Receiver) -> LastingTransport:
    """The first transport of `opener`, and then the next; someone has to run its `keep_open`.

    Raises:
        LinkError: the first cannot be opened.
        InputError: the address names something that is not there.
    """
    lasting = LastingTransport(opener, receiver)
    lasting.current = await opener(lasting)
    return lasting
