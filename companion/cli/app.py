"""The root of the command: subcommands, exit statuses, and errors in one line."""

import signal
import sys
from typing import Annotated

import typer
from rich.console import Console

from companion import __version__
from companion.cli.lazy import lazy_group
from companion.cli.lines import show
from companion.errors import ImpromptuError

COMMANDS = {
    "fly": "Fly a trajectory, and say how closely it was tracked.",
    "sitl": "Serve a simulated quadrotor over MAVLink.",
    "collect": "Fly the training trajectory, and write the data set.",
    "report": "Show flights from their recordings: a table, and a page with pictures.",
    "replay": "Compute a recorded flight again, and show where today's code does otherwise.",
    "train": "Train an inverse network on a data set.",
    "doctor": "Say what would stop a flight of a vehicle, and what to set.",
    "identify": "Fit a simulated vehicle to a flight log of the real one.",
    "similarity": "Say whether the network of one vehicle serves another.",
}
BENCHMARKS = {
    "recording": "What crashes and power cuts leave of a recording.",
    "linear": "The paper's simulation: one linear system's inverse network steers another.",
    "pairs": "The inverse of one random linear system steers another, a thousand times.",
    "quadrotor": "The paper's flights: one quadrotor's inverse network steers another.",
    "step": "What one control step costs.",
    "transfer": "Every vehicle's inverse network on every other vehicle.",
    "faults": "One thing after the other fails in flight: what is done, and how it ends.",
    "fuzz": "Hostile bytes through every reader: no crash, no hang, no valid frame lost.",
    "soak": "Hours of simulated flight: memory, lateness, records.",
    "period": "How regular setpoints are in real time while all cores are busy.",
    "fidelity": "Recordings of real vehicles against their simulated twins.",
}
MISSION = {
    "upload": "Upload a plan, and read it back.",
    "download": "Write a vehicle's plan to a file.",
    "validate": "Say what would keep a plan from being flown.",
    "start": "Have a vehicle fly its mission.",
    "clear": "Delete a vehicle's mission, fence and rally points.",
}
PARAMS = {
    "pull": "Write a vehicle's parameters to a file.",
    "push": "Set a vehicle's parameters from a file, and verify each.",
    "diff": "Show where two files or vehicles differ.",
}

app = typer.Typer(
    name="companion",
    help="Companion software for multirotors: accurate tracking of any trajectory on the first attempt.",
    cls=lazy_group("companion.cli.", COMMANDS),
    no_args_is_help=True,
    pretty_exceptions_enable=False,
    rich_markup_mode="markdown",
    context_settings={"help_option_names": ["-h", "--help"]},
)
bench = typer.Typer(
    name="bench",
    help="Benchmarks: the paper's experiments, and simulated vehicles against real ones.",
    cls=lazy_group("companion.cli.bench_", BENCHMARKS),
    no_args_is_help=True,
)
app.add_typer(bench)
params = typer.Typer(
    name="params",
    help="A vehicle's parameters: to a file, from a file, compared.",
    cls=lazy_group("companion.cli.params_", PARAMS),
    no_args_is_help=True,
)
app.add_typer(params)
mission = typer.Typer(
    name="mission",
    help="Plans: to a vehicle, from a vehicle, checked, flown by its autopilot.",
    cls=lazy_group("companion.cli.mission_", MISSION),
    no_args_is_help=True,
)
app.add_typer(mission)


def _show_version(wanted: bool) -> None:
    if wanted:
        typer.echo(f"impromptu {__version__}")
        raise typer.Exit


@app.callback()
def _root(
    debug: Annotated[bool, typer.Option("--debug", help="Show the traceback of an error.")] = False,
    version: Annotated[
        bool, typer.Option("--version", callback=_show_version, is_eager=True, help="Show the version.")
    ] = False,
) -> None:
    """Companion software for multirotors."""


@bench.callback()
def _bench() -> None:
    """Benchmarks."""


@mission.callback()
def _mission() -> None:
    """Plans."""


@params.callback()
def _params() -> None:
    """Parameters."""


def main() -> None:
    """Run the command line: exit status 0 done, 1 the flight or job failed, 2 wrong use."""
    _stop_as_by_ctrl_c(signal.SIGTERM, signal.SIGHUP)
    try:
        app()
    except ImpromptuError as error:
        if "--debug" in sys.argv:
            raise
        _say(f"error: {error}")
        sys.exit(error.exit_status)
    except Exception as error:
        if "--debug" in sys.argv:
            raise
        _say(f"error: unexpected {type(error).__name__}: {error} (`companion --debug ...` shows where)")
        sys.exit(1)


def _say(text: str) -> None:
    show(Console(stderr=True), text, style="red")


def _stop_as_by_ctrl_c(*signals: signal.Signals) -> None:
    """A service manager or a terminal that goes away ends the program as Ctrl-C does: with a hold.

    So does Ctrl-C itself where a shell's `&` made the program deaf to it: a flight can always be stopped.
    """
    signal.signal(signal.SIGINT, signal.default_int_handler)
    for number in signals:
        if signal.getsignal(number) is signal.SIG_DFL:  # `nohup` keeps its meaning
            signal.signal(number, lambda *_: signal.raise_signal(signal.SIGINT))
