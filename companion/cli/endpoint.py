"""How to reach a vehicle, for commands that talk to one without flying it."""

from collections.abc import Awaitable, Callable
from dataclasses import dataclass
from typing import TypeVar

from rich.console import Console

from companion import clock
from companion.cli.lines import show
from companion.link import Connection, connect, parse_address
from companion.link.address import Simulated
from companion.link.exposure import warning
from companion.link.signing import SigningKey

T = TypeVar("T")


@dataclass(frozen=True, slots=True)
class Endpoint:
    """How to reach a vehicle.

    Attributes:
        url: connection string.
        system_id: of the vehicle; None for the first that is heard.
        signing: what frames are signed with; None where they are not.
    """

    url: str
    system_id: int | None = None
    signing: SigningKey | None = None


def with_vehicle(endpoint: Endpoint, work: Callable[[Connection], Awaitable[T]]) -> T:
    """What `work` makes of a connection to the vehicle at `endpoint`; raises as `connect`."""
    address = parse_address(endpoint.url)
    if told := warning([address], signed=endpoint.signing is not None):
        show(Console(stderr=True), told)

    async def connected() -> T:
        async with connect(address, system_id=endpoint.system_id, signing=endpoint.signing) as connection:
            return await work(connection)

    return clock.run(connected(), virtual=isinstance(address, Simulated))
