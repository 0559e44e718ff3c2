"""How bytes reach the vehicle and come back: one small interface, whatever is behind it.

Everything happens in the event loop: bytes are handed on where they arrive, and nothing waits in a queue.
"""

from typing import Protocol


class Receiver(Protocol):
    """Whoever is told what happens on a transport; neither call may raise."""

    def bytes_received(self, data: bytes) -> None:
        """Bytes arrived."""
        ...

    def transport_lost(self, error: Exception) -> None:
        """The transport ended by itself, because of `error`."""
        ...


class Transport(Protocol):
    """A way to one peer, or to whoever turns up."""

    @property
    def dropped(self) -> int:
        """How many frames were not sent because the peer was unknown, or did not read."""
        ...

    def send(self, data: bytes) -> None:
        """Send one frame, or drop it: never waits, and never lets old frames pile up."""
        ...

    def answer_sender(self) -> None:
        """Called while bytes are being received: their sender is the peer from now on."""
        ...

    async def aclose(self) -> None:
        """Close it, and wait until it is closed."""
        ...
