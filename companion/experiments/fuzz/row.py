"""What came of one block of hostile input."""

import traceback

from pydantic import BaseModel, ConfigDict

_LONGEST_TEXT = 300
_MOST_FAULTS = 8


class FuzzRow(BaseModel):
    """One block: many inputs to one reader.

    Attributes:
        reader: which.
        inputs: how many mutated frames, pieces of noise or files it was given.
        refused: how many of them it refused as it should, where it is one to refuse.
        valid: how many valid frames were among them.
        swallowed: of these, how many lay in a longer frame whose checksum was right by chance.
        lost: of these, how many others were not read.
        faults: what else it raised, and where; and what it did not end by itself.
        slowest_s: the most that one input, or stream of 64, took of the processor (s).
        grown_bytes: memory that the second half of the block took.
        wall_s: what the block took (s).
    """

    model_config = ConfigDict(frozen=True)

    reader: str
    inputs: int
    refused: int = 0
    valid: int = 0
    swallowed: int = 0
    lost: int = 0
    faults: tuple[str, ...] = ()
    slowest_s: float = 0.0
    grown_bytes: int = 0
    wall_s: float = 0.0


def described(error: BaseException) -> str:
    """The error and the line that raised it."""
    while isinstance(error, BaseExceptionGroup):
        error = error.exceptions[0]
    frames = traceback.extract_tb(error.__traceback__)
    ours = [at for at in frames if "site-packages" not in at.filename and "fuzz" not in at.filename] or frames
    where = f"{ours[-1].filename.rpartition('/')[2]}:{ours[-1].lineno}"
    return f"{type(error).__name__} at {where}: {error}"[:_LONGEST_TEXT]


def some(faults: list[str]) -> tuple[str, ...]:
    """As many different ones as a row has room for."""
    return tuple(dict.fromkeys(faults))[:_MOST_FAULTS]
