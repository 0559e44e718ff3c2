"""`companion bench soak`: hours of simulated flight."""

from typing import Annotated

import typer
from rich.console import Console

from companion import __version__
from companion.cli import options
from companion.cli.lines import show
from companion.cli.result_file import write_result
from companion.cli.resumed import journal_of, rows_of
from companion.experiments.contenders import find_model
from companion.experiments.simulated_flights import prepare_simulator
from companion.experiments.soak import FLIGHT_S, Piece, SoakRow, belongs_to, pieces, run
from companion.learning.online_settings import DEFAULT

_MOST_GROWN = 0.05
_MOST_DRIFT_S = 1e-3
_S_PER_HOUR = 3600.0


def soak(
    hours: Annotated[float, typer.Option(min=0.001, help="Of simulated flight, in all.")] = 8.0,
    processes: Annotated[int, typer.Option(min=1, max=100, help="That share the hours.")] = 2,
    flight: Annotated[float, typer.Option(min=10.0, help="Seconds that each flight tracks.")] = FLIGHT_S,
    vehicle: options.SimulatedVehicle = "bebop2",
    model: options.DnnGpModel = "ardrone2",
    conditions: Annotated[
        str, typer.Option(help="A name in config/conditions, or a YAML file.")
    ] = "realistic",
    seed: options.Seed = 0,
    json: options.Json = None,
) -> None:
    """Fly for hours of virtual time, flight after flight in one process: from takeoff to landing, recorded.

    With --json FILE, what a process has flown is kept in FILE.flown: the same command goes on from there.
    Exit status 1 where memory grew by more than 5 % after the first flight, setpoints drifted, or a record
    was lost.

    Example: companion bench soak --hours 1 --json soak.json
    """
    console = Console()
    if json is not None:
        options.writable(json)
    network = find_model(model, DEFAULT).network
    todo = pieces(Piece(vehicle, conditions, network, seed, hours * _S_PER_HOUR, flight), processes)
    with console.status("Preparing the simulator (half a minute the first time)"):
        prepare_simulator([vehicle], conditions)
    rows = rows_of(todo, run, SoakRow, belongs_to=belongs_to(todo), json=json, console=console)
    show(console, *map(_line, rows))
    if json is not None:
        settings = {"hours": hours, "processes": processes, "flight_s": flight, "vehicle": vehicle}
        settings |= {"model": model, "conditions": conditions, "seed": seed}
        told = [row.model_dump() | {"grown": row.grown} for row in rows]
        write_result({"pieces": told, "settings": settings, "software": __version__}, json)
        journal_of(json).unlink(missing_ok=True)
    if any(row.grown > _MOST_GROWN or row.drift_s > _MOST_DRIFT_S or row.lost for row in rows):
        raise typer.Exit(1)


def _line(row: SoakRow) -> str:
    return (
        f"{row.flights} flights in {row.simulated_s / _S_PER_HOUR:.2f} h, {row.setpoints} setpoints: memory "
        f"{row.warm_bytes / 1e6:.1f} → {row.end_bytes / 1e6:.1f} MB ({row.grown:+.1%}), drift "
        f"{row.drift_s * 1e6:.1f} µs, {row.lost} records lost; worst RMS {row.worst_rms_m:.3f} m; took "
        f"{row.wall_s:.0f} s"
    )
