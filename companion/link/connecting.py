"""From a connection string to the vehicle behind it."""

from collections.abc import AsyncIterator, Sequence
from contextlib import AsyncExitStack, asynccontextmanager
from functools import partial

from companion.errors import InputError
from companion.link.address import Address, Simulated, parse_address
from companion.link.connection import Connection, connect_over
from companion.link.forward import forwarding
from companion.link.opening import open_transport
from companion.link.signing import SigningKey
from companion.link.signing_state import lasting_signer


@asynccontextmanager
async def connect(
    address: str | Address,
    *,
    system_id: int | None = None,
    signing: SigningKey | None = None,
    forward: Sequence[str | Address] = (),
    timeout_s: float = 10.0,
) -> AsyncIterator[Connection]:
    """Connect to the vehicle at `address`, until the block ends.

    A link that breaks later does not end the block: it is opened again, and `Connection.presence` tells.

    Args:
        address: a connection string, such as `udpin://0.0.0.0:14540`, or what it means.
        system_id: of the vehicle; without it, the first vehicle that is heard.
        signing: signs what is sent; only what is signed with it is believed. Without it, anything is.
        forward: where there are ground stations that share the link: frames pass both ways.
        timeout_s: how long to wait for the vehicle's heartbeat (s).

    Raises:
        InputError: a connection string is wrong, or the timestamps of signatures cannot be kept.
        LinkError: a transport cannot be opened, or no vehicle is there.
    """
    target, *grounds = (_meaning(place) for place in (address, *forward))
    if any(isinstance(ground, Simulated) for ground in grounds):
        raise InputError(
            "frames cannot be forwarded to the built-in vehicle: name where the ground station is"
        )
    if grounds and isinstance(target, Simulated):
        raise InputError("the built-in vehicle flies in a time of its own: run `companion sitl` to share it")
    async with AsyncExitStack() as stack:
        signer = await stack.enter_async_context(lasting_signer(signing)) if signing else None
        connection = await stack.enter_async_context(
            connect_over(
                partial(open_transport, target), system_id=system_id, signer=signer, timeout_s=timeout_s
            )
        )
        for ground in grounds:
            await stack.enter_async_context(forwarding(connection, partial(open_transport, ground)))
        yield connection


def _meaning(place: str | Address) -> Address:
    return parse_address(place) if isinstance(place, str) else place
