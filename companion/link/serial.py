"""Serial ports, such as a flight controller's TELEM2."""

import asyncio
from typing import cast

import serial_asyncio_fast

from companion.link.address import Serial
from companion.link.os_errors import explained
from companion.link.stream import StreamTransport
from companion.link.transport import Receiver


async def open_serial(address: Serial, receiver: Receiver) -> StreamTransport:
    """The open serial port at `address`, which no other program can open until it is closed.

    Raises:
        LinkError: there is no such device, permission denied, another program has it open.
    """
    what = f"serial port {address.path}"
    with explained(what):
        _, stream = await serial_asyncio_fast.create_serial_connection(
            asyncio.get_running_loop(),
            lambda: StreamTransport(receiver, what),
            address.path,
            baudrate=address.baud_rate,
            exclusive=True,
        )
    return cast(StreamTransport, stream)
