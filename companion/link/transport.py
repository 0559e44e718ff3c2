"""How bytes reach the vehicle and come back: one small interface, and one place that picks what is behind it.

Everything happens in the event loop: bytes are handed on where they arrive, and nothing waits in a queue.
"""

from typing import Protocol

from companion.link.address import Address, Serial, Simulated, TcpIn, TcpOut, UdpIn, UdpOut


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


async def open_transport(address: Address, receiver: Receiver) -> Transport:
    """The open transport to `address`.

    Raises:
        LinkError: the port is taken, the host unknown, permission denied.
        InputError: `address` names a vehicle or conditions that are not there.
    """
    # What a transport needs is imported only where it is used: the built-in vehicle takes seconds.
    match address:
        case UdpIn() | UdpOut():
            from companion.link.udp import open_udp

            return await open_udp(address, receiver)
        case TcpOut() | TcpIn():
            from companion.link.tcp import open_tcp

            return await open_tcp(address, receiver)
        case Serial():
            from companion.link.serial import open_serial

            return await open_serial(address, receiver)
        case Simulated():
            from companion.link.simulated import open_simulated

            return open_simulated(address, receiver)
