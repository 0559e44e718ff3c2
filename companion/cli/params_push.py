"""`companion params push`: parameters from a file into a vehicle, each verified."""

import sys
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Annotated

import typer
from rich.box import SIMPLE_HEAD
from rich.console import Console
from rich.table import Table

from companion.cli import options
from companion.cli.endpoint import Endpoint, with_vehicle
from companion.cli.params import progress_bar, read_file, read_vehicle
from companion.cli.result_file import write_result
from companion.errors import InputError, RefusedError
from companion.link import Connection
from companion.link.parameter import set_parameters
from companion.link.parameter_changes import changes_to
from companion.link.parameter_encoding import Parameter, parameter_encoding
from companion.link.parameter_file import written


def push(
    file: Annotated[
        Path,
        typer.Argument(dir_okay=False, help="Parameters: of QGroundControl, MAVProxy or Mission Planner."),
    ],
    connect: options.Connect,
    system_id: options.SystemId = None,
    signing_key: options.SigningKeyFile = None,
    yes: Annotated[bool, typer.Option("--yes", help="Set without asking.")] = False,
    dry_run: Annotated[
        bool, typer.Option("--dry-run", help="Show what would be set, and set nothing.")
    ] = False,
    json: options.Json = None,
) -> None:
    """Set the parameters in a file that differ from the vehicle's, and verify each.

    Nothing is set when the file has a parameter that the vehicle does not have, or has in another type.

    Example: companion params push mine.params --connect udpin://0.0.0.0:14540 --dry-run
    """
    if json is not None:
        options.writable(json)
    endpoint = Endpoint(connect, system_id, options.signing_key(signing_key))
    console = Console()
    wanted = read_file(file, console)
    found = read_vehicle(endpoint, console)
    changes = changes_to(found.parameters, wanted, file)
    if changes:
        console.print(_table(found.parameters, changes))
    else:
        console.print(f"nothing to set: the vehicle has all {len(wanted)} values")
    refused: Mapping[str, str] = {}
    if changes and not dry_run:
        if not (yes or _agreed(len(changes))):
            console.print("nothing was set")
            return
        refused = _set(replace(endpoint, system_id=found.system_id), changes, console)
        console.print(f"{len(changes) - len(refused)} of {len(changes)} set and verified")
    if json is not None:
        write_result(_result(found.parameters, changes, refused, dry_run), json)
    if refused:
        told = "; ".join(f"{name}: {why}" for name, why in refused.items())
        raise RefusedError(f"the vehicle did not take all parameters: {told}")


def _agreed(count: int) -> bool:
    if not sys.stdin.isatty():
        raise InputError("there is nobody to ask: say --yes to set them, or --dry-run to see them")
    return typer.confirm(f"Set {count} parameters?")


def _set(endpoint: Endpoint, changes: Sequence[Parameter], console: Console) -> Mapping[str, str]:
    async def work(connection: Connection) -> Mapping[str, str]:
        encoding = await parameter_encoding(connection)
        with progress_bar(console, "setting parameters") as show:
            return await set_parameters(
                connection, changes, encoding, progress=lambda done: show(done, len(changes))
            )

    return with_vehicle(endpoint, work)


def _table(vehicle: Mapping[str, Parameter], changes: Sequence[Parameter]) -> Table:
    table = Table("parameter", box=SIMPLE_HEAD)
    table.add_column("now", justify="right")
    table.add_column("to set", justify="right")
    for each in changes:
        table.add_row(each.name, written(vehicle[each.name].value), written(each.value))
    return table


def _result(
    vehicle: Mapping[str, Parameter],
    changes: Sequence[Parameter],
    refused: Mapping[str, str],
    dry_run: bool,
) -> dict[str, object]:
    return {
        "dry_run": dry_run,
        "changes": [
            {
                "name": each.name,
                "before": vehicle[each.name].value,
                "after": each.value,
                "refused": refused.get(each.name),
            }
            for each in changes
        ],
    }
