"""`companion replay`: a recorded flight through today's code."""

import math
from dataclasses import asdict
from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console
from rich.table import Table

from companion.cli import options
from companion.cli.lines import show
from companion.cli.result_file import write_result
from companion.errors import InputError
from companion.flight.replay import Replayed
from companion.flight.replay import replay as replayed
from companion.flight.technique import Technique
from companion.learning.inverse_network import InverseNetwork
from companion.learning.library import Library

_MOST_ROWS = 20


def replay(
    flight: Annotated[Path, typer.Argument(dir_okay=False, help="Recording of a flight (MCAP).")],
    model: options.Model = None,
    json: options.Json = None,
) -> None:
    """Feed what a flight saw to today's code, and show where it does otherwise.

    When nothing changed, every number is the same to the last bit, on the same kind of machine with the same
    numpy; the exit status is 1 when one is not. --model names the network that was flown, where it is not
    found by the name it had then.

    Example: companion replay flights/20260501T123456Z-star-gp.mcap
    """

    def network(technique: Technique) -> InverseNetwork | Library | None:
        name = model or technique.model
        if options.model_sha256(name) != technique.model_sha256:
            raise InputError(
                f"{name} is not the model that was flown: give that by --model "
                f"(SHA-256 {technique.model_sha256})"
            )
        return options.network(name)

    console = Console()
    with console.status(f"replaying {flight}"):
        found = replayed(flight, network)
    if not found.whole:
        show(console, f"{flight} was cut short: what is left of it was replayed")
    if json is not None:
        write_result(asdict(found), json)
    if not found.differences:
        show(console, f"{found.steps} control steps: the same to the last bit")
        return
    show(console, f"{found.steps} control steps; {len(found.differences)} signals came out otherwise:")
    console.print(_table(found))
    raise typer.Exit(1)


def _table(found: Replayed) -> Table:
    table = Table("signal", "first after (s)", "steps", "largest difference")
    for difference in found.differences[:_MOST_ROWS]:
        largest = "there or not" if math.isinf(difference.largest) else f"{difference.largest:.3g}"
        after_s = difference.first_s - found.start_s
        table.add_row(difference.signal, f"{after_s:.2f}", str(difference.count), largest)
    if len(found.differences) > _MOST_ROWS:
        table.add_row(f"and {len(found.differences) - _MOST_ROWS} more")
    return table
