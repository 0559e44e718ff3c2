"""`companion bench recording`: what crashes and power cuts leave of a flight's recording."""

from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Annotated

import numpy as np
import typer
from rich.console import Console
from rich.progress import track

from companion import bundled
from companion.cli import options
from companion.cli.lines import show
from companion.cli.result_file import write_result
from companion.experiments.cut_recordings import losses_s, record
from companion.experiments.simulated_flights import Scenario
from companion.flight.strategies import Strategy
from companion.trajectory import Limits, Placement, read_trajectory

_MOST_LOST_S = 1.0


def recording(
    cuts: Annotated[int, typer.Option(min=1, help="How many cuts.")] = 1000,
    seed: options.Seed = 0,
    json: options.Json = None,
) -> None:
    """Record a flight, cut the file at random bytes, and read what is left: all but the last second.

    Example: companion bench recording --cuts 100 --json cuts.json
    """
    console = Console()
    trajectory = read_trajectory(bundled.find("trajectories", "star", ".csv"), Placement(), Limits())
    scenario = Scenario(trajectory, Strategy.GP, conditions="realistic", seed=seed)
    with TemporaryDirectory() as folder:
        path = Path(folder) / "flight.mcap"
        with console.status("flying"):
            epoch_s = record(scenario, path)
        size, link_size = path.stat().st_size, path.with_suffix(".tlog").stat().st_size
        cutting = losses_s(path, epoch_s, cuts, seed)
        lost = np.array(list(track(cutting, "cutting", cuts, console=console, transient=True)))
    result = {
        "cuts": cuts,
        "unreadable": int(np.isinf(lost).sum()),
        "worst_loss_s": float(lost.max()),
        "mean_loss_s": float(lost.mean()),
        "bytes": size,
        "link_bytes": link_size,
        "seed": seed,
    }
    show(
        console,
        f"{cuts} cuts of a recording of {size / 1e6:.1f} MB (link {link_size / 1e6:.1f} MB): "
        f"{result['unreadable']} unreadable, at most the last {lost.max():.2f} s lost, on average "
        f"{lost.mean():.2f} s",
    )
    if json is not None:
        write_result(result, json)
    if lost.max() > _MOST_LOST_S:
        raise typer.Exit(1)
