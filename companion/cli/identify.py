"""`companion identify`: from a flight log to a simulated twin of the vehicle that flew it."""

import math
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Annotated, Any

import typer
from rich.box import SIMPLE_HEAD
from rich.console import Console
from rich.table import Table

from companion import __version__
from companion.cli import options
from companion.cli.lines import show
from companion.cli.result_file import write_result
from companion.errors import InputError
from companion.recording import Recording, Segment, read_recording
from companion.recording.card import log_name

try:
    from companion.experiments.estimator_fit import fit_estimator_errors
    from companion.experiments.fidelity import TwinFlight, fly_segment, segments_of
    from companion.experiments.fitted_file import fitted_file
    from companion.experiments.identification import Estimated, Identification, Shot, shots_of
    from companion.experiments.identification import identify as fit
    from companion.experiments.twin import twin_vehicle
    from companion.experiments.twin_plots import plot_twin
    from companion.experiments.vehicle_parameters import (
        Parameter,
        default_parameters,
        file_values,
        parameter,
    )
    from companion.experiments.wander import SHORTEST_HOVER_S
    from sitl import files
    from sitl.estimator_errors import EstimatorErrors
    from sitl.vehicle import Vehicle
except ModuleNotFoundError as missing:
    raise InputError(
        f"identifying a vehicle needs {missing.name}, which is not installed: pip install 'impromptu[bench]'"
    ) from missing


@dataclass(frozen=True, eq=False)
class _Chosen:
    """The part of a recording that is fitted to, and the stretches in which it is flown."""

    path: Path
    recording: Recording
    segments: Sequence[Segment]
    shots: Sequence[Shot]


def identify(
    recordings: options.FlightLogs,
    vehicle: Annotated[
        str, typer.Option(help="What to start from: a name in config/vehicles, or your own YAML file.")
    ],
    output: Annotated[
        Path | None, typer.Option(dir_okay=False, help="Write the fitted vehicle to this YAML file.")
    ] = None,
    parameters: Annotated[
        str | None,
        typer.Option(
            help="Which to fit, by key, with commas between: rotors.time_constant_s,mass_kg. "
            "Default: what shows most, by firmware.",
            show_default=False,
        ),
    ] = None,
    segments: Annotated[
        str | None,
        typer.Option(
            help="Fit to the segments in whose names one of these occurs, with commas between. Default: all.",
            show_default=False,
        ),
    ] = None,
    system_id: options.SystemIdInLog = None,
    json: options.Json = None,
    plot: Annotated[
        Path | None, typer.Option(dir_okay=False, help="Draw the fitted twin against the log (PNG).")
    ] = None,
) -> None:
    """Find the numbers of a vehicle file with which the simulated vehicle flies as the recorded one did.

    Bounds are a quarter of the start to four times it. With a hover window in the recording, the errors of
    the estimator are fitted to it and to the flight as well.

    Example: companion identify flight.tlog --vehicle x500.yaml --output mine.yaml --plot mine.png
    """
    for path in (output, json, plot):
        if path is not None:
            options.writable(path)
    console = Console()
    twin = twin_vehicle(vehicle)
    wanted = _parameters(twin, parameters)
    with console.status("reading") as status:
        chosen = [_chosen(path, segments, system_id) for path in recordings]
        shots = [shot for each in chosen for shot in each.shots]
        status.update("preparing the simulator")
        found = fit(
            twin,
            shots,
            wanted,
            lambda number, rms_m: status.update(f"step {number}, twin {rms_m:.3f} m from the log"),
        )
        status.update("fitting the estimator")
        estimator = _estimator(found.vehicle, chosen)
    console.print(_table(found))
    notes = _notes(found)
    show(console, *notes, style="yellow")
    if output is not None:
        _write(output, vehicle, twin, found, estimator, [each.path.name for each in chosen])
        show(console, f"vehicle: {output}")
    if json is not None:
        fitted = {"vehicle": vehicle, "recordings": [_named(each) for each in chosen]}
        write_result(_as_json(found, estimator, notes) | fitted | {"software": __version__}, json)
    if plot is not None:
        with console.status("drawing"):
            plot_twin([flight for each in chosen for flight in _flights(found.vehicle, each)], plot)
        show(console, f"plot: {plot}")


def _parameters(vehicle: Vehicle, keys: str | None) -> Sequence[Parameter]:
    if keys is None:
        return default_parameters(vehicle)
    try:
        return [parameter(vehicle, key) for key in dict.fromkeys(each.strip() for each in keys.split(","))]
    except InputError as error:
        raise InputError(f"--parameters: {error}") from error


def _chosen(path: Path, names: str | None, system_id: int | None) -> _Chosen:
    recording = read_recording(path, system_id=system_id)
    try:
        segments = _called(segments_of(recording), names)
        return _Chosen(path, recording, segments, shots_of(recording, segments))
    except InputError as error:
        raise InputError(f"{path}: {error}") from error


def _called(segments: Sequence[Segment], names: str | None) -> Sequence[Segment]:
    """Those in whose names one of `names` occurs."""
    if names is None:
        return segments
    parts = [each.strip() for each in names.split(",")]
    called = [segment for segment in segments if any(part in segment.id for part in parts)]
    if not called:
        listed = ", ".join(segment.id for segment in segments)
        raise InputError(f"no segment is called like {names}; there are {listed}")
    return called


def _flights(vehicle: Vehicle, chosen: _Chosen) -> list[TwinFlight]:
    return [fly_segment(vehicle, chosen.recording, segment) for segment in chosen.segments]


def _estimator(vehicle: Vehicle, recordings: Sequence[_Chosen]) -> EstimatorErrors | None:
    """Fitted to the first recording with a hover that is long enough, if there is one."""
    for each in recordings:
        hover = each.recording.hover
        if hover is not None and hover.end_s - hover.start_s >= SHORTEST_HOVER_S:
            return fit_estimator_errors(vehicle, each.recording, each.segments)
    return None


def _table(found: Identification) -> Table:
    table = Table(
        box=SIMPLE_HEAD,
        title=f"twin {found.start_rms_m:.3f} m RMS from the log before, {found.rms_m:.3f} m after",
        caption=f"95 % confidence intervals; {found.shots} stretches flown",
    )
    table.add_column("parameter", no_wrap=True)
    for head in ("start", "fitted", "±"):
        table.add_column(head, justify="right", no_wrap=True)
    for each in found.estimates:
        figures = (f"{each.parameter.start:.4g}", f"{each.value:.4g}", f"{each.half_width:.2g}")
        table.add_row(each.parameter.key, *figures)
    return table


def _notes(found: Identification) -> list[str]:
    notes = [
        f"{each.parameter.key} is at its bound: start from another value, or leave it out"
        for each in found.estimates
        if each.at_bound
    ]
    notes += [
        f"{each.parameter.key} hardly shows in this flight: keep what you know of it"
        for each in found.estimates
        if not each.identifiable
    ]
    if not found.converged:
        notes.append("the fit was stopped before it came to rest: fit fewer parameters, or start nearer")
    return notes


def _write(
    output: Path,
    vehicle: str,
    start: Vehicle,
    found: Identification,
    estimator: EstimatorErrors | None,
    logs: Sequence[str],
) -> None:
    remarks = [
        f"Fitted to {', '.join(logs)}: {found.rms_m:.3f} m RMS, {found.start_rms_m:.3f} m before.",
        *(_remark(each) for each in found.estimates),
    ]
    values = file_values(start, {each.parameter.key: each.value for each in found.estimates})
    text = fitted_file(files.find("vehicles", vehicle), values, estimator, remarks)
    output.write_text(text, encoding="utf-8")


def _remark(each: Estimated) -> str:
    return f"{each.parameter.key}: {each.parameter.start:.4g} -> {each.value:.4g} ± {each.half_width:.2g}"


def _named(chosen: _Chosen) -> dict[str, Any]:
    return {"name": log_name(chosen.path), "segments": [segment.id for segment in chosen.segments]}


def _as_json(
    found: Identification, estimator: EstimatorErrors | None, notes: Sequence[str]
) -> dict[str, Any]:
    return {
        "start_rms_m": found.start_rms_m,
        "rms_m": found.rms_m,
        "stretches": found.shots,
        "converged": found.converged,
        "parameters": [
            asdict(each.parameter)
            | {
                "value": each.value,
                "half_width_95": each.half_width if math.isfinite(each.half_width) else None,
                "identifiable": each.identifiable,
                "at_bound": each.at_bound,
            }
            for each in found.estimates
        ],
        "estimator": None if estimator is None else estimator.model_dump(exclude_defaults=True),
        "notes": list(notes),
    }
