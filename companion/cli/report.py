"""`companion report`: flights from their logs, as a table and as a page with pictures."""

import shlex
import sys
from pathlib import Path
from typing import Annotated

import typer
from rich.box import SIMPLE_HEAD
from rich.console import Console
from rich.table import Column, Table

from companion.cli import options
from companion.cli.lines import show
from companion.cli.result_file import write_result
from companion.errors import InputError
from companion.experiments.flight_report import COLUMNS, table_row, write_flight_report
from companion.experiments.logged_flights import LoggedFlight, read_logged_flight, told_apart


def report(
    flights: Annotated[
        list[Path], typer.Argument(dir_okay=False, help="Recordings of flights (MCAP), .tlog or .ulg.")
    ],
    output: Annotated[Path, typer.Option(file_okay=False, help="Folder of the page.")] = Path(
        "reports/flights"
    ),
    json: options.Json = None,
) -> None:
    """Say how closely each flight was tracked, and draw it.

    A recording that was cut short is read as far as it goes; files without a flight are named, and left out.
    Errors are against the vehicle's own estimate; in logs of other programs, what was sent stands for what
    was wanted.

    Example: companion report flights/*.mcap
    """
    console = Console()
    with console.status("reading"):
        read = [_read(path) for path in flights]
    unread = [each for each in read if isinstance(each, InputError)]
    logged = told_apart([each for each in read if isinstance(each, LoggedFlight)])
    if not logged:
        raise unread[0]
    show(console, *(f"left out: {error}" for error in unread))
    cut = [each.path for each in logged if not each.recording.whole]
    show(console, *(f"{path} was cut short: what is left of it is shown" for path in cut))
    table = Table(*(Column(name, overflow="fold") for name in COLUMNS), box=SIMPLE_HEAD)
    for each in logged:
        table.add_row(*table_row(each))
    console.print(table)
    if json is not None:
        left_out = [str(error) for error in unread]
        write_result({"flights": [_result(each) for each in logged], "left_out": left_out}, json)
    with console.status("drawing"):
        page = write_flight_report(logged, output, shlex.join(["companion", *sys.argv[1:]]))
    show(console, f"report: {page}")


def _read(path: Path) -> LoggedFlight | InputError:
    try:
        return read_logged_flight(path)
    except InputError as error:
        return error


def _result(logged: LoggedFlight) -> dict[str, object]:
    accuracy, flight = logged.accuracy, logged.flight
    return {
        "file": str(logged.path),
        "whole": logged.recording.whole,
        "trajectory": flight.trajectory_name,
        "duration_s": float(flight.time_s[-1] - flight.time_s[0]),
        "rms_m": accuracy.rms_m,
        "rms_axes_m": accuracy.rms_axes_m.tolist(),
        "max_m": accuracy.max_m,
        "largest_correction_m": logged.largest_correction_m,
        "provenance": logged.recording.provenance.model_dump(mode="json"),
    }
