"""Serial ports, such as a flight controller's TELEM2."""

import asyncio
from functools import partial
from typing import cast

import serial  # type: ignore[import-untyped]
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
        # Some USB adapters take seconds to open, and a flight that gets its cable back has no second to lose.
        port = await asyncio.to_thread(
            partial(serial.Serial, address.path, baudrate=address.baud_rate, exclusive=True)
        )
        _, stream = await serial_asyncio_fast.connection_for_serial(
            asyncio.get_running_loop(), lambda: StreamTransport(receiver, what), port
        )
    return cast(StreamTransport, stream)
