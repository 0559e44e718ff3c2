"""What `params pull`, `push` and `diff` share: a vehicle's parameters, read with progress shown."""

from collections.abc import Awaitable, Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import TypeVar

from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn

from companion import clock
from companion.autopilot import Identity, identify
from companion.errors import InputError
from companion.link import Connection, connect, parse_address
from companion.link.address import Simulated
from companion.link.parameter_encoding import Encoding, Parameter, parameter_encoding
from companion.link.parameter_file import FileParameter, read_parameter_file
from companion.link.parameter_list import list_parameters
from companion.link.signing import SigningKey

T = TypeVar("T")


@dataclass(frozen=True, slots=True)
class Place:
    """Where a vehicle is.

    Attributes:
        url: connection string.
        system_id: of the vehicle; None for the first that is heard.
        signing: what frames are signed with; None where they are not.
    """

    url: str
    system_id: int | None = None
    signing: SigningKey | None = None


@dataclass(frozen=True, slots=True)
class Found:
    """A vehicle, and all of its parameters by name."""

    system_id: int
    identity: Identity
    parameters: Mapping[str, Parameter]


def read_vehicle(place: Place, console: Console) -> Found:
    """The parameters of the vehicle at `place`; raises as `connect` and `list_parameters`."""

    async def read(connection: Connection, encoding: Encoding) -> Found:
        with progress_bar(console, "reading parameters") as show:
            parameters = await list_parameters(connection, encoding, progress=show)
        return Found(connection.system_id, await identify(connection), parameters)

    return with_vehicle(place, read)


def with_vehicle(place: Place, work: Callable[[Connection, Encoding], Awaitable[T]]) -> T:
    """What `work` makes of a connection to the vehicle at `place`, and of its parameters' encoding."""
    address = parse_address(place.url)

    async def connected() -> T:
        async with connect(address, system_id=place.system_id, signing=place.signing) as connection:
            return await work(connection, await parameter_encoding(connection))

    return clock.run(connected(), virtual=isinstance(address, Simulated))


def read_file(path: Path, console: Console) -> list[FileParameter]:
    """The autopilot's parameters in a file; tells how many of other components were left out.

    Raises:
        InputError: as `read_parameter_file`, or there are none of the autopilot.
    """
    found = read_parameter_file(path)
    own = [each for each in found if each.is_of_autopilot]
    if not own:
        raise InputError(f"{path}: no parameters of an autopilot (component 1) in it")
    if len(own) < len(found):
        console.print(f"{len(found) - len(own)} parameters of other components left out")
    return own


@contextmanager
def progress_bar(console: Console, what: str) -> Iterator[Callable[[int, int], None]]:
    """Shows how many are done of how many."""
    columns = (TextColumn(what), BarColumn(), MofNCompleteColumn())
    with Progress(*columns, console=console, transient=True, disable=not console.is_terminal) as bar:
        task = bar.add_task(what, total=None)
        yield lambda done, total: bar.update(task, completed=done, total=total)
