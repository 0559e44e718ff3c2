"""`companion bench period`: setpoints on a loaded machine."""

from dataclasses import asdict
from typing import Annotated

import typer
from rich.console import Console

from companion import __version__, bundled
from companion.cli import options
from companion.cli.lines import show
from companion.cli.result_file import write_result
from companion.experiments.contenders import find_model
from companion.experiments.loaded import cores, fly_loaded
from companion.experiments.simulated_flights import Scenario
from companion.flight.strategies import Strategy
from companion.learning.online_settings import DEFAULT
from companion.trajectory import Limits, Placement, read_trajectory

_MS = 1e3


def period(
    trajectory: options.Drawing = "star",
    model: options.DnnGpModel = "ardrone2",
    vehicle: options.SimulatedVehicle = "bebop2",
    busy: Annotated[
        int | None, typer.Option(min=0, help="Processes that do other work. Default: one for each core.")
    ] = None,
    priority: Annotated[
        bool, typer.Option(help="Take the priority over other programs that `companion fly` takes.")
    ] = True,
    seed: options.Seed = 0,
    json: options.Json = None,
) -> None:
    """Fly in real time over UDP on loopback while other processes keep all cores busy.

    Exit status 1 where one period in a hundred is more than 20 % too long, or the flight was ended.

    Example: companion bench period --json period.json
    """
    console = Console()
    if json is not None:
        options.writable(json)
    path = bundled.find("trajectories", trajectory, ".csv")
    scenario = Scenario(
        read_trajectory(path, Placement(), Limits()),
        Strategy.DNN_GP,
        vehicle,
        seed=seed,
        network=find_model(model, DEFAULT).network,
    )
    with console.status("flying in real time"):
        told = fly_loaded(scenario, cores() if busy is None else busy, with_priority=priority)
    show(
        console,
        f"{told.setpoints} setpoints every {told.nominal_s * _MS:g} ms beside {told.busy} busy processes on "
        f"{cores()} cores, priority {told.priority}: median {told.p50_s * _MS:.1f} ms, 99 in 100 within "
        f"{told.p99_s * _MS:.1f} ms, longest {told.max_s * _MS:.1f} ms; RMS error {told.rms_m:.3f} m",
        *([f"the flight was ended: {told.failsafe}"] if told.failsafe else []),
    )
    if json is not None:
        settings = {"trajectory": trajectory, "model": model, "vehicle": vehicle, "seed": seed}
        write_result(
            asdict(told)
            | {"holds": told.holds, "cores": cores(), "settings": settings, "software": __version__},
            json,
        )
    if not told.holds:
        raise typer.Exit(1)
