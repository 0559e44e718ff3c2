"""What came of hostile input, reader by reader."""

from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass

from rich.table import Table

from companion.experiments.fuzz.row import FuzzRow

MOST_GROWN_BYTES = 4_000_000
"""A reader that keeps something of every input takes more than that in each block; others do now and then."""


@dataclass(frozen=True)
class Summary:
    """The rows of one reader together; as in `FuzzRow`, but for `grown_bytes`, which every block took."""

    reader: str
    inputs: int
    refused: int
    valid: int
    swallowed: int
    lost: int
    faults: tuple[str, ...]
    slowest_s: float
    grown_bytes: int
    wall_s: float

    @property
    def fails(self) -> bool:
        """Whether anything is as it should not be."""
        return bool(self.lost or self.faults) or self.grown_bytes > MOST_GROWN_BYTES


def summaries(rows: Sequence[FuzzRow]) -> list[Summary]:
    """One for each reader, in the order of the rows."""
    return [
        _summary([row for row in rows if row.reader == name])
        for name in dict.fromkeys(row.reader for row in rows)
    ]


def _summary(rows: Sequence[FuzzRow]) -> Summary:
    return Summary(
        reader=rows[0].reader,
        inputs=sum(row.inputs for row in rows),
        refused=sum(row.refused for row in rows),
        valid=sum(row.valid for row in rows),
        swallowed=sum(row.swallowed for row in rows),
        lost=sum(row.lost for row in rows),
        faults=tuple(dict.fromkeys(fault for row in rows for fault in row.faults)),
        slowest_s=max(row.slowest_s for row in rows),
        grown_bytes=min(row.grown_bytes for row in rows),
        wall_s=sum(row.wall_s for row in rows),
    )


def figures(told: Sequence[Summary]) -> dict[str, object]:
    """For programs."""
    return {
        "inputs": sum(each.inputs for each in told),
        "lost": sum(each.lost for each in told),
        "faults": sum(len(each.faults) for each in told),
        "readers": [asdict(each) | {"fails": each.fails} for each in told],
    }


def table(told: Sequence[Summary]) -> Table:
    """For people."""
    shown = Table("reader", "inputs", "refused", "frames", "swallowed", "lost", "faults", "slowest", "grown")
    for each in told:
        frames = (each.valid, each.swallowed, each.lost) if each.valid else ("", "", "")
        cells = (each.inputs, each.refused or "", *frames, len(each.faults))
        shown.add_row(
            each.reader, *map(str, cells), f"{each.slowest_s:.2f} s", f"{each.grown_bytes / 1e6:.1f}"
        )
    shown.caption = "frames: valid ones among the inputs; swallowed by longer ones; grown: MB in each block"
    return shown


def complaints(told: Sequence[Summary]) -> Iterator[str]:
    """What is as it should not be, in words."""
    for each in told:
        yield from (f"{each.reader}: {fault}" for fault in each.faults)
        if each.lost:
            yield f"{each.reader}: {each.lost} valid frames were lost"
        if each.grown_bytes > MOST_GROWN_BYTES:
            yield f"{each.reader}: every block of inputs took {each.grown_bytes / 1e6:.0f} MB"
