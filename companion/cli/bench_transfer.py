"""`companion bench transfer`: every network on every other vehicle."""

from functools import partial
from typing import Annotated

import typer
from rich.console import Console

from companion import __version__
from companion.cli import options
from companion.cli.lines import show
from companion.cli.result_file import write_result
from companion.cli.resumed import journal_of, rows_of
from companion.errors import InputError
from companion.trajectory.placement import Placement

try:
    from companion.experiments.backend import Backend
    from companion.experiments.lasa import BENCHMARK_NAMES
    from companion.experiments.trajectories import courses
    from companion.experiments.transfer import (
        CONDITIONS,
        VEHICLES,
        Transfer,
        TransferRow,
        figures,
        fly,
        own_models,
        pair_table,
        summary,
    )
except ModuleNotFoundError as missing:
    raise InputError(
        f"the benchmark needs {missing.name}, which is not installed: pip install 'impromptu[bench]'"
    ) from missing


def transfer(
    vehicles: Annotated[
        list[str] | None,
        typer.Option(
            help="At least two, each with a network of its own in config/models. "
            f"Default: {', '.join(VEHICLES)}."
        ),
    ] = None,
    trajectories: Annotated[
        list[str] | None,
        typer.Option(
            help="CSV files, drawings of config/trajectories or LASA shapes. Default: ten LASA shapes."
        ),
    ] = None,
    conditions: Annotated[
        list[str] | None,
        typer.Option(help=f"Names in config/conditions, or YAML files. Default: {', '.join(CONDITIONS)}."),
    ] = None,
    size: options.Size = 3.0,
    speed: options.Speed = None,
    plane: options.PlaneOption = options.Plane.XZ,
    seed: options.Seed = 0,
    backend: Annotated[
        str, typer.Option(help="Of joblib: loky is this machine's cores; dask or ray is a cluster.")
    ] = "loky",
    scheduler: Annotated[
        str | None, typer.Option(metavar="URL", help="Of Dask's cluster: tcp://HOST:8786.")
    ] = None,
    json: options.Json = None,
) -> None:
    """Fly every vehicle with the network of every other (dnn+gp), and with baseline and gp beside.

    With --json FILE, each flight is kept in FILE.flown as it ends: the same command goes on from there after
    it was stopped.

    Example: companion bench transfer --json transfer.json

    Example: companion bench transfer --vehicles bebop2 iris --conditions windy --json windy.json
    """
    if json is not None:
        options.writable(json)
    flown_by = list(dict.fromkeys(vehicles or VEHICLES))
    if len(flown_by) < 2:
        raise InputError("--vehicles: give at least two different ones")
    names = trajectories or list(BENCHMARK_NAMES)
    placement = Placement(size_m=size, plane=plane.value)
    drawings, notes = courses(names, placement, flown_by, [] if speed is None else [speed])
    job = Transfer(own_models(flown_by), list(dict.fromkeys(conditions or CONDITIONS)), drawings, seed)
    console = Console()
    with console.status("Preparing the simulator (half a minute the first time)"):
        job.prepare()
    on_backend = partial(fly, backend=Backend(backend, scheduler))
    rows = rows_of(
        job.flights(), on_backend, TransferRow, belongs_to=job.fingerprint(), json=json, console=console
    )
    _show(rows, job, console)
    notes += [f"{row.source} on {row.target}, {row.trajectory}: {row.error}" for row in rows if row.error]
    show(console, *notes, style="yellow")
    if json is not None:
        settings = {
            "vehicles": flown_by,
            "trajectories": names,
            "conditions": job.conditions,
            "size_m": size,
            "speed_m_s": speed,
            "plane": plane,
            "seed": seed,
        }
        write_result(figures(rows) | {"settings": settings, "notes": notes, "software": __version__}, json)
        journal_of(json).unlink(missing_ok=True)


def _show(rows: list[TransferRow], job: Transfer, console: Console) -> None:
    console.print(*(pair_table(rows, conditions) for conditions in job.conditions))
    told = summary(rows)
    if told.mean_reduction is not None:
        console.print(
            f"mean reduction {told.mean_reduction:.3f}, worst {told.worst_ratio:.2f} times the baseline; "
            f"{told.worse_than_baseline} of {told.flights} flights worse than the baseline"
        )
