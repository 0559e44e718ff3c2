"""How often the verdict was right, over pairs that were flown with the network and without."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np
from pydantic import BaseModel, ConfigDict, FiniteFloat, ValidationError

from companion.bounded_file import read_bounded
from companion.errors import InputError
from companion.similarity.verdict import Verdict

_LARGEST_FILE_BYTES = 50_000_000
_WORSE = 0.03
_WORSE_M = 0.005
"""A network harms where the RMS error with it is greater by more than both."""
WITH, WITHOUT = "dnn+gp", "gp"


class FlownRow(BaseModel):
    """One flight of `companion bench transfer --json`; further keys are passed over."""

    model_config = ConfigDict(frozen=True)

    source: str | None = None
    target: str
    trajectory: str
    conditions: str
    strategy: str
    rms_m: FiniteFloat | None


class FlownPairs(BaseModel):
    """The file of `companion bench transfer --json`."""

    model_config = ConfigDict(frozen=True)

    rows: tuple[FlownRow, ...]


class Pair(NamedTuple):
    """A source and a target in some conditions."""

    source: str
    target: str
    conditions: str


class TrackRecord(NamedTuple):
    """How often a verdict was right.

    Attributes:
        right, pairs: counts.
        wrong: the pairs on which it was not.
    """

    right: int
    pairs: int
    wrong: tuple[Pair, ...]


def read_flown_pairs(file: Path) -> FlownPairs:
    """The flights in a file.

    Raises:
        InputError: it cannot be read, or is of another form; names the key.
    """
    try:
        return FlownPairs.model_validate_json(read_bounded(file, _LARGEST_FILE_BYTES))
    except ValidationError as error:
        fault = error.errors(include_url=False)[0]
        key = ".".join(map(str, fault["loc"])) or "the file"
        raise InputError(
            f"{file}: {key}: {fault['msg']}; it is to be a file of `companion bench transfer --json`"
        ) from error


def network_helped(rows: Sequence[FlownRow]) -> dict[Pair, bool]:
    """For each pair, whether the mean RMS error with the network was not worse than without.

    A flight that failed counts as worse. Pairs that were not flown both ways are left out.
    """
    without: dict[tuple[str, str], list[float]] = {}
    flown: dict[Pair, dict[str, list[float]]] = {}
    for row in rows:
        rms = np.inf if row.rms_m is None else row.rms_m
        if row.strategy == WITHOUT and row.source is None:
            without.setdefault((row.target, row.conditions), []).append(rms)
        elif row.source is not None:
            pair = Pair(row.source, row.target, row.conditions)
            flown.setdefault(pair, {}).setdefault(row.strategy, []).append(rms)
    helped = {}
    for pair, by_strategy in flown.items():
        plain = by_strategy.get(WITHOUT) or without.get((pair.target, pair.conditions))
        if WITH in by_strategy and plain:
            bearable = max((1.0 + _WORSE) * np.mean(plain), np.mean(plain) + _WORSE_M)
            helped[pair] = bool(np.mean(by_strategy[WITH]) <= bearable)
    return helped


def track_record(verdicts: Mapping[Pair, Verdict], helped: Mapping[Pair, bool]) -> TrackRecord:
    """Right is a transfer that did not harm, and a refusal of one that would have."""
    judged = [pair for pair in helped if pair in verdicts]
    wrong = tuple(pair for pair in judged if verdicts[pair].transfers is not helped[pair])
    return TrackRecord(len(judged) - len(wrong), len(judged), wrong)
