"""`companion mission start`: have a vehicle fly its mission, and see it through."""

import asyncio
from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console

from companion.autopilot import detect
from companion.cli import options
from companion.cli.display import FlightDisplay
from companion.cli.endpoint import Endpoint, with_vehicle
from companion.cli.flying import STOPPED
from companion.cli.lines import show
from companion.cli.mission import summary, transfer_bar
from companion.cli.result_file import write_result
from companion.errors import InputError
from companion.link import Connection, start_telemetry
from companion.mission.files import read_plan
from companion.mission.items import Plan
from companion.mission.progress import fly_mission, start_mission
from companion.mission.transfer import download_plan, upload_plan


def start(
    connect: options.Connect,
    file: Annotated[
        Path | None,
        typer.Argument(
            dir_okay=False, help="Plan to upload first; without it, the vehicle flies the one it has."
        ),
    ] = None,
    wait: Annotated[bool, typer.Option("--wait", help="Follow the mission until it is done.")] = False,
    system_id: options.SystemId = None,
    signing_key: options.SigningKeyFile = None,
    json: options.Json = None,
) -> None:
    """Arm the vehicle, and have it fly its mission.

    With --wait each item is told as it is reached, and the exit status is 1 when the mission ended early: a
    pilot who changes the mode has the vehicle. Ctrl-C leaves it to its mission.

    Example: companion mission start survey.plan --connect sitl://bebop2 --wait
    """
    plan = None if file is None else read_plan(file)
    if json is not None:
        options.writable(json)
    endpoint = Endpoint(connect, system_id, options.signing_key(signing_key))
    console = Console()
    try:
        reached = with_vehicle(endpoint, lambda connection: _start(connection, plan, wait, console))
    except KeyboardInterrupt:
        raise typer.Exit(STOPPED) from None
    if json is not None:
        write_result({"done": wait, "reached": reached}, json)


async def _start(connection: Connection, plan: Plan | None, wait: bool, console: Console) -> list[int]:
    """Which items were reached, in order."""
    with transfer_bar(console) as progress:
        if plan is not None:
            await upload_plan(connection, plan, progress, lambda text: show(console, text))
        else:
            plan = await download_plan(connection, progress)
    if not plan.mission:
        raise InputError("there is no mission to fly: name a file, or upload one")
    telemetry = await start_telemetry(connection)
    autopilot = await detect(connection, telemetry)
    reached = []
    with FlightDisplay(console) as display:
        connection.status_texts.subscribe(display.vehicle_said)
        display.phase(summary(plan))
        if not wait:
            await start_mission(connection, telemetry, autopilot, display.phase)
            display.phase("the vehicle flies its mission")
            return []
        try:
            async for item in fly_mission(connection, telemetry, autopilot, plan.mission, display.phase):
                display.phase(f"reached {item.index + 1} of {item.total}: {item.item.name}")
                reached.append(item.index)
        except asyncio.CancelledError:
            display.phase("stopped looking: a vehicle that flies its mission goes on with it")
            raise
        display.phase("the mission is done")
    return reached
