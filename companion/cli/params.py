"""What `params pull`, `push` and `diff` share: a vehicle's parameters, read with progress shown."""

from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn

from companion.autopilot import Identity, identify
from companion.cli.endpoint import Endpoint, with_vehicle
from companion.errors import InputError
from companion.link import Connection
from companion.link.parameter_encoding import Parameter, parameter_encoding
from companion.link.parameter_file import FileParameter, read_parameter_file
from companion.link.parameter_list import list_parameters


@dataclass(frozen=True, slots=True)
class Found:
    """A vehicle, and all of its parameters by name."""

    system_id: int
    identity: Identity
    parameters: Mapping[str, Parameter]


def read_vehicle(endpoint: Endpoint, console: Console) -> Found:
    """The parameters of the vehicle at `endpoint`; raises as `connect` and `list_parameters`."""

    async def read(connection: Connection) -> Found:
        encoding = await parameter_encoding(connection)
        with progress_bar(console, "reading parameters") as show:
            parameters = await list_parameters(connection, encoding, progress=show)
        return Found(connection.system_id, await identify(connection), parameters)

    return with_vehicle(endpoint, read)


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
