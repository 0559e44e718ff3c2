"""`companion bench faults`: flights in which something fails."""

from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console

from companion import __version__
from companion.cli import options
from companion.cli.result_file import write_result
from companion.cli.resumed import journal_of, rows_of
from companion.errors import InputError
from companion.learning.online_settings import DEFAULT
from companion.trajectory.placement import Placement

try:
    from companion.experiments.contenders import find_model
    from companion.experiments.faults.catalogue import Failure, catalogue, kinds_among
    from companion.experiments.faults.flight import Phase
    from companion.experiments.faults.job import FaultJob, fly
    from companion.experiments.faults.table import figures, lost_table, markdown
    from companion.experiments.faults.verdict import FaultRow
    from companion.experiments.trajectories import limits_within, named_trajectories
except ModuleNotFoundError as missing:
    raise InputError(
        f"the benchmark needs {missing.name}, which is not installed: pip install 'impromptu[bench]'"
    ) from missing

_SIZE_M = 2.0
_VEHICLES = ("bebop2", "arducopter_sitl")
"""One of each firmware."""


def faults(
    only: Annotated[
        list[str] | None,
        typer.Option(
            metavar="KIND",
            help="Kinds of fault, as many as you like. Default: all, of the vehicle (companion sitl "
            "--fault-kinds), its link and the companion.",
        ),
    ] = None,
    phases: Annotated[
        list[Phase] | None, typer.Option(help="When it fails. Default: takeoff, tracking and landing.")
    ] = None,
    seeds: Annotated[int, typer.Option(min=1, max=1000, help="Flights of each, with seeds from 0 on.")] = 5,
    vehicle: Annotated[
        list[str] | None,
        typer.Option(
            help="That is flown: a name in config/vehicles, or a YAML file; as many as you like. Default: "
            f"{', '.join(_VEHICLES)}, PX4 and ArduPilot."
        ),
    ] = None,
    model: Annotated[
        str | None,
        typer.Option(
            help="Network that is flown with: a name in config/models, or a file. Default: that of the "
            "vehicle's own name."
        ),
    ] = None,
    trajectory: options.Drawing = "clef",
    conditions: options.Conditions = "realistic",
    json: options.Json = None,
    page: Annotated[
        Path | None, typer.Option("--markdown", dir_okay=False, help="Write the fault table to this file.")
    ] = None,
) -> None:
    """Let one thing after the other fail in flight; say what is done about it, and how it ends.

    With --json FILE, each flight is kept in FILE.flown as it ends: the same command goes on from there after
    it was stopped. Exit status 1 where a flight was lost that could be survived.

    Example: companion bench faults --json faults.json --markdown faults.md

    Example: companion bench faults --only gps_lost --only gust --phases tracking --seeds 1
    """
    for file in (json, page):
        if file is not None:
            options.writable(file)
    vehicles = vehicle or _VEHICLES
    job = FaultJob(
        named_trajectories([trajectory], Placement(size_m=_SIZE_M), limits_within(vehicles, None))[0],
        _chosen(only),
        phases or list(Phase),
        range(seeds),
        {each: find_model(model or Path(each).stem, DEFAULT) for each in vehicles},
        conditions,
    )
    console = Console()
    with console.status("Preparing the simulator (half a minute the first time)"):
        job.prepare()
    rows = rows_of(job.flights(), fly, FaultRow, belongs_to=job.fingerprint(), json=json, console=console)
    told = figures(rows)
    console.print(lost_table(rows))
    summary = told["summary"]
    console.print(", ".join(f"{key.replace('_', ' ')} {value}" for key, value in summary.items()))
    if json is not None:
        settings = {
            "vehicles": list(job.models),
            "models": [model.name for model in job.models.values()],
            "trajectory": trajectory,
            "conditions": conditions,
            "phases": job.phases,
            "seeds": seeds,
        }
        write_result(told | {"settings": settings, "software": __version__}, json)
        journal_of(json).unlink(missing_ok=True)
    if page is not None:
        page.write_text(markdown(rows), encoding="utf-8")
    if any(row.lost and row.survivable and row.struck for row in rows):
        raise typer.Exit(1)


def _chosen(only: list[str] | None) -> list[Failure]:
    every = list(catalogue())
    unknown = set(only or ()) - set(kinds_among(every))
    if unknown:
        raise InputError(f"--only {min(unknown)}: no such kind; there are {', '.join(kinds_among(every))}")
    return [failure for failure in every if not only or failure.kind in only]
