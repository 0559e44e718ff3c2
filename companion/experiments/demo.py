"""The main job in one go, `python -m companion.experiments.demo`, which `scripts/demo` runs.

Three drawings that ship with the program, flown by the built-in Bebop 2 with every strategy; the inverse
network is the AR.Drone's.
"""

import sys
from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console
from rich.progress import track
from rich.table import Table

from companion.errors import FlightError, ImpromptuError
from companion.experiments.comparison import Comparison, failures, flights, rms_errors
from companion.experiments.contenders import find_model, own_model_name, transferred
from companion.experiments.lookahead import measured_lookahead_s
from companion.experiments.report import write_report
from companion.experiments.results import results_table
from companion.experiments.simulated_flights import prepare_simulator
from companion.experiments.trajectories import limits_within, named_trajectories
from companion.flight.strategies import Strategy
from companion.learning.online_settings import DEFAULT
from companion.trajectory.placement import Placement

SOURCE, TARGET = "ardrone2", "bebop2"
DRAWINGS = ("star", "clef", "signature")
LEGEND: dict[str, str] = {
    Strategy.BASELINE: "sends position and velocity of the drawing",
    Strategy.FEEDFORWARD: "sends its acceleration too",
    Strategy.LOOKAHEAD: "sends position and velocity a constant time early",
    Strategy.DNN: f"sends what {SOURCE}'s inverse network says",
    Strategy.GP: "is feedforward, somewhat early, corrected by a model of the last ten seconds of flight",
    Strategy.DNN_GP: "goes part of the way from there to what the network says, likewise",
}


def demo(
    output: Annotated[Path, typer.Option(file_okay=False, help="Directory of the report.")] = Path(
        "reports/demo"
    ),
    conditions: Annotated[
        str, typer.Option(help="Wind, noise and delays: a name in config/conditions, or a YAML file.")
    ] = "realistic",
    seed: Annotated[int, typer.Option(min=0, help="Of wind, noise and delays.")] = 0,
) -> None:
    """Fly three drawings with every strategy, and write a report with pictures.

    Example: scripts/demo --conditions windy
    """
    console = Console()
    console.print(_introduction(conditions))
    model = find_model(own_model_name(SOURCE, DEFAULT), DEFAULT)
    drawings = named_trajectories(DRAWINGS, Placement(), limits_within([TARGET], None))
    with console.status("Preparing the simulator; the first time takes half a minute"):
        prepare_simulator([TARGET], conditions)
    with console.status(f"Flying {TARGET} along sinusoids to find the best constant lookahead"):
        lookahead_s = measured_lookahead_s(TARGET, conditions, seed)
    contenders = transferred(TARGET, list(Strategy), model, lookahead_s)
    comparison = Comparison(drawings, contenders, conditions, seed)
    results = dict(track(comparison.fly(), "Flying", len(comparison), console=console, transient=True))
    if not flights(results):
        raise FlightError(f"not one flight came to its end: {failures(results)[0]}")

    console.print(results_table(rms_errors(results)))
    for line in failures(results):
        console.print(f"failed: {line}", style="yellow", markup=False, highlight=False, soft_wrap=True)
    with console.status("Drawing the report"):
        page = write_report(
            flights(results),
            output,
            title="Three drawings, flown on the first attempt",
            conditions={
                "vehicle": f"{TARGET} (simulated)",
                "network of": SOURCE,
                "conditions": conditions,
                "seed": str(seed),
                "lookahead time": f"{lookahead_s:.2f} s",
                **LEGEND,
            },
            commands=[f"scripts/demo --conditions {conditions} --seed {seed}"],
        )
    console.print(f"report: {page}", markup=False, highlight=False, soft_wrap=True)


def _introduction(conditions: str) -> Table:
    table = Table.grid(padding=(0, 2))
    table.title = f"The simulated {TARGET} flies {len(DRAWINGS)} drawings in {conditions} conditions"
    for strategy, what in LEGEND.items():
        table.add_row(f"  {strategy}", what)
    return table


if __name__ == "__main__":
    try:
        typer.run(demo)
    except ImpromptuError as error:
        Console(stderr=True).print(f"error: {error}", style="red", markup=False, soft_wrap=True)
        sys.exit(error.exit_status)
