"""`companion params pull`: a vehicle's parameters into a file."""

from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console

from companion.cli import options
from companion.cli.endpoint import Endpoint
from companion.cli.lines import show
from companion.cli.params import read_vehicle
from companion.link.parameter_file import write_parameter_file

_STACKS = {"PX4": "PX4 Pro", "ArduPilot": "ArduPilot"}


def pull(
    file: Annotated[Path, typer.Argument(dir_okay=False, help="File to write, as QGroundControl reads it.")],
    connect: options.Connect,
    system_id: options.SystemId = None,
    signing_key: options.SigningKeyFile = None,
) -> None:
    """Write all parameters of a vehicle to a file that QGroundControl reads.

    Example: companion params pull mine.params --connect udpin://0.0.0.0:14540
    """
    options.writable(file)
    endpoint = Endpoint(connect, system_id, options.signing_key(signing_key))
    console = Console()
    found = read_vehicle(endpoint, console)
    stack, version = found.identity.autopilot, found.identity.version
    about = [f"Stack: {_STACKS.get(stack, stack)}", "Vehicle: Multi-Rotor"]
    if version is not None:
        about.append(f"Version: {version}")
    write_parameter_file(file, found.parameters.values(), system_id=found.system_id, about=about)
    show(console, f"{len(found.parameters)} parameters of system {found.system_id}, {stack}: {file}")
