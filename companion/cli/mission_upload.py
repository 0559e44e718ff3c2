"""`companion mission upload`: a plan from a file into a vehicle, verified by reading it back."""

from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console

from companion.cli import options
from companion.cli.endpoint import Endpoint, with_vehicle
from companion.cli.flying import STOPPED
from companion.cli.lines import show
from companion.cli.mission import counts, summary, transfer_bar
from companion.cli.result_file import write_result
from companion.link import Connection
from companion.mission.files import read_plan
from companion.mission.transfer import upload_plan


def upload(
    file: Annotated[Path, typer.Argument(dir_okay=False, help="Plan: .plan or QGC WPL 110.")],
    connect: options.Connect,
    system_id: options.SystemId = None,
    signing_key: options.SigningKeyFile = None,
    json: options.Json = None,
) -> None:
    """Upload a mission, and fence and rally points if the file has any; then read them back and compare.

    When it fails, or Ctrl-C stops it, the vehicle keeps its former mission.

    Example: companion mission upload survey.plan --connect udpin://0.0.0.0:14540
    """
    plan = read_plan(file)
    if json is not None:
        options.writable(json)
    endpoint = Endpoint(connect, system_id, options.signing_key(signing_key))
    console = Console()

    async def work(connection: Connection) -> int:
        connection.status_texts.subscribe(lambda line: show(console, f"vehicle: {line.text}"))
        with transfer_bar(console) as progress:
            await upload_plan(connection, plan, progress, lambda text: show(console, text))
        return connection.system_id

    try:
        uploaded_to = with_vehicle(endpoint, work)
    except KeyboardInterrupt:
        raise typer.Exit(STOPPED) from None
    show(console, f"uploaded to system {uploaded_to} and verified: {summary(plan)}")
    if json is not None:
        result = {"file": str(file), "system_id": uploaded_to, "verified": True, **counts(plan)}
        write_result(result, json)
