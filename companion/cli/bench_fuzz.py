"""`companion bench fuzz`: hostile input through every reader."""

from typing import Annotated

import typer
from rich.console import Console

from companion import __version__
from companion.cli import options
from companion.cli.lines import show
from companion.cli.result_file import write_result
from companion.cli.resumed import journal_of, rows_of
from companion.experiments.fuzz.job import belongs_to, blocks, prepare, run
from companion.experiments.fuzz.row import FuzzRow
from companion.experiments.fuzz.table import complaints, figures, summaries, table


def fuzz(
    frames: Annotated[
        int, typer.Option(min=0, help="Mutated frames and pieces of noise on a link.")
    ] = 10_000_000,
    files: Annotated[int, typer.Option(min=0, help="Mutated files of each kind.")] = 5_000,
    seed: options.Seed = 0,
    json: options.Json = None,
) -> None:
    """Send mutated MAVLink frames to both ends of a link, and mutated files to every reader.

    Whatever is wrong must be refused with an error of our own, in bounded time and memory; and each valid
    frame among the noise must be read, unless it lies in a longer one before it that is valid by chance.
    With --json FILE, what is done is kept in FILE.flown: the same command goes on from there. Exit status 1
    where a reader failed.

    Example: companion bench fuzz --frames 100000 --files 1000 --json fuzz.json
    """
    console = Console()
    if json is not None:
        options.writable(json)
    with console.status("Preparing the simulator (half a minute the first time)"):
        prepare()
        todo = blocks(frames, files, seed)
    rows = rows_of(todo, run, FuzzRow, belongs_to=belongs_to(todo), json=json, console=console)
    told = summaries(rows)
    console.print(table(told))
    show(console, *complaints(told))
    if json is not None:
        settings = {"frames": frames, "files": files, "seed": seed}
        write_result(figures(told) | {"settings": settings, "software": __version__}, json)
        journal_of(json).unlink(missing_ok=True)
    if any(each.fails for each in told):
        raise typer.Exit(1)
