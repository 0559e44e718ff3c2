"""Long jobs of many parts: shown as they go on, kept in a file as they end, and taken up from there."""

from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import TypeVar

from pydantic import BaseModel
from rich.console import Console
from rich.progress import track

from companion.experiments.journal import Journal

Part = TypeVar("Part")
Row = TypeVar("Row", bound=BaseModel)


def journal_of(json: Path) -> Path:
    """Where the rows of the job are kept whose result is to be in `json`."""
    return json.with_name(f"{json.name}.flown")


def rows_of(
    parts: Sequence[Part],
    work: Callable[[Sequence[Part]], Iterator[Row]],
    row_type: type[Row],
    *,
    belongs_to: str,
    json: Path | None,
    console: Console,
) -> list[Row]:
    """A row of each part, some of them perhaps from an earlier run; without `json`, nothing is kept.

    Raises:
        InputError: the file is of another job, or cannot be written.
    """
    if json is None:
        return list(track(work(parts), "Working", len(parts), console=console, transient=True))
    journal = Journal(journal_of(json), row_type, belongs_to=belongs_to, most=len(parts))
    done = len(journal.rows)
    if done:
        console.print(f"{done} of {len(parts)} parts were done before")
    left = work(parts[done:])
    for row in track(left, "Working", len(parts), completed=done, console=console, transient=True):
        journal.append(row)
    return journal.rows
