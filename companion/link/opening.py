"""From an address to the open transport behind it."""

from companion.link.address import Address, Serial, Simulated, TcpIn, TcpOut, UdpIn, UdpOut
from companion.link.transport import Receiver, Transport


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
