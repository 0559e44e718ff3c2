"""`companion bench fidelity`: simulated vehicles against recordings of the real ones."""

import shlex
import sys
from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console
from rich.progress import Progress

from companion import __version__
from companion.cli import options
from companion.cli.lines import show
from companion.cli.result_file import write_result
from companion.errors import InputError
from companion.recording import Recording, read_recording
from companion.recording.card import log_name

try:
    from companion.experiments.fidelity import evaluate_all, pooled, segments_of
    from companion.experiments.fidelity_report import write_fidelity_report
    from companion.experiments.fidelity_tables import (
        RecordingFidelity,
        as_json,
        hover_line,
        pooled_line,
        prediction_table,
        twin_table,
    )
    from companion.experiments.twin import twin_vehicle
    from companion.experiments.wander import compare_wander
    from sitl.vehicle import Vehicle
except ModuleNotFoundError as missing:
    raise InputError(
        f"the benchmark needs {missing.name}, which is not installed: pip install 'impromptu[bench]'"
    ) from missing


def fidelity(
    recordings: options.FlightLogs,
    vehicle: Annotated[
        str | None,
        typer.Option(
            help="The twin: a name in config/vehicles, or a YAML file. Default: what each recording names.",
            show_default=False,
        ),
    ] = None,
    system_id: options.SystemIdInLog = None,
    json: options.Json = None,
    report: options.PageDirectory = None,
) -> None:
    """Fly recordings again with simulated vehicles, and compare; and predict them with the online model.

    Each segment of a recording begins in the recorded state, and sends what was sent.

    Example: companion bench fidelity flight.tlog --vehicle px4_sih --json fidelity.json
    """
    if json is not None:
        options.writable(json)
    console = Console()
    with Progress(console=console, transient=True) as progress:
        reading = progress.add_task("Reading", total=len(recordings))
        read = []
        for path in recordings:
            recording = read_recording(path, system_id=system_id)
            read.append((path, recording, _twin(path, recording, vehicle)))
            progress.advance(reading)
        fidelities = [_evaluated(progress, *each) for each in read]
    for each in fidelities:
        console.print(twin_table(each), prediction_table(each))
        whole = pooled(each.flights)
        if whole is not None:
            show(console, pooled_line(whole))
        if each.hover is not None:
            show(console, hover_line(each.hover))
    if json is not None:
        result = {"recordings": [as_json(each) for each in fidelities], "software": __version__}
        write_result(result, json)
    if report is not None:
        page = write_fidelity_report(fidelities, report, shlex.join(["companion", *sys.argv[1:]]))
        show(console, f"report: {page}")


def _twin(path: Path, recording: Recording, vehicle: str | None) -> Vehicle:
    if vehicle is not None:
        return twin_vehicle(vehicle)
    try:
        return twin_vehicle(recording.provenance.vehicle)
    except InputError as error:
        raise InputError(f"{path}: name its twin by --vehicle: {error}") from error


def _evaluated(progress: Progress, path: Path, recording: Recording, vehicle: Vehicle) -> RecordingFidelity:
    try:
        flying = progress.add_task(f"Flying {path.name}", total=len(segments_of(recording)))
        segments = []
        for segment in evaluate_all(vehicle, recording):
            segments.append(segment)
            progress.advance(flying)
        hover = compare_wander(vehicle, recording)
    except InputError as error:
        raise InputError(f"{path}: {error}") from error
    return RecordingFidelity(log_name(path), vehicle.name, segments, hover)
