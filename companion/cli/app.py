"""The root of the command: subcommands, exit statuses, and errors in one line."""

import sys
from typing import Annotated

import typer
from rich.console import Console

from companion import __version__
from companion.errors import ImpromptuError

app = typer.Typer(
    name="companion",
    help="Companion software for multirotors: accurate tracking of any trajectory on the first attempt.",
    no_args_is_help=True,
    pretty_exceptions_enable=False,
    rich_markup_mode="markdown",
    context_settings={"help_option_names": ["-h", "--help"]},
)
bench = typer.Typer(no_args_is_help=True, help="Benchmarks: the paper's experiments, reproduced.")

_STOPPED = 130  # what shells report for a program that Ctrl-C ended


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


def main() -> None:
    """Run the command line: exit status 0 done, 1 the flight or job failed, 2 wrong use."""
    try:
        app()
    except ImpromptuError as error:
        if "--debug" in sys.argv:
            raise
        Console(stderr=True).print(f"error: {error}", style="red", markup=False, highlight=False)
        sys.exit(error.exit_status)
    except KeyboardInterrupt:
        Console(stderr=True).print("stopped", style="yellow")
        sys.exit(_STOPPED)
