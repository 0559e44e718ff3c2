"""`companion mission download`: the plan of a vehicle into a file."""

from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console

from companion.cli import options
from companion.cli.endpoint import Endpoint, with_vehicle
from companion.cli.lines import show
from companion.cli.mission import counts, summary, transfer_bar
from companion.cli.result_file import write_result
from companion.link import Connection
from companion.mission.files import write_plan
from companion.mission.items import Plan
from companion.mission.transfer import download_plan


def download(
    file: Annotated[
        Path, typer.Argument(dir_okay=False, help="File to write: .plan, or .waypoints for QGC WPL 110.")
    ],
    connect: options.Connect,
    system_id: options.SystemId = None,
    signing_key: options.SigningKeyFile = None,
    json: options.Json = None,
) -> None:
    """Write a vehicle's mission, fence and rally points to a file that QGroundControl reads.

    Example: companion mission download flown.plan --connect udpin://0.0.0.0:14540
    """
    for path in (file, json):
        if path is not None:
            options.writable(path)
    endpoint = Endpoint(connect, system_id, options.signing_key(signing_key))
    console = Console()

    async def work(connection: Connection) -> tuple[int, Plan]:
        with transfer_bar(console) as progress:
            return connection.system_id, await download_plan(connection, progress)

    downloaded_from, plan = with_vehicle(endpoint, work)
    write_plan(plan, file)
    show(console, f"downloaded from system {downloaded_from}: {summary(plan)}: {file}")
    if json is not None:
        result = {"file": str(file), "system_id": downloaded_from, **counts(plan)}
        write_result(result, json)
