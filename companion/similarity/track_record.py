"""How often the verdict was right, over pairs that were flown with the network and without."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

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


class Tally(NamedTuple):
    """Of how many pairs a verdict was given, and for how many it was right."""

    right: int
    pairs: int


class Mistake(NamedTuple):
    """A pair on which the verdict was wrong."""

    source: str
    target: str
    conditions: str
    verdict: Verdict


@dataclass(frozen=True)
class TrackRecord:
    """How often verdicts were right.

    Attributes:
        flown: the flights that showed it.
        tallies: by verdict.
        wrong: the pairs on which it was not; None where they are not known by name.
    """

    flown: str
    tallies: Mapping[Verdict, Tally]
    wrong: tuple[Mistake, ...] | None = None

    @property
    def right(self) -> int:
        """Of `pairs`."""
        return sum(tally.right for tally in self.tallies.values())

    @property
    def pairs(self) -> int:
        """All that were flown and judged."""
        return sum(tally.pairs for tally in self.tallies.values())

    @property
    def refused_though_harmless(self) -> int:
        """Networks that would have done no harm."""
        return self._wrong_of(transfers=False)

    @property
    def allowed_though_harmful(self) -> int:
        """Networks that did harm."""
        return self._wrong_of(transfers=True)

    @property
    def right_if_always_transfer(self) -> int:
        """What the constant answer "transfer" would have scored: a verdict is worth what it adds to that."""
        return self.right - self._right_of(transfers=False) + self.refused_though_harmless

    def _right_of(self, *, transfers: bool) -> int:
        return sum(tally.right for each, tally in self.tallies.items() if each.transfers is transfers)

    def _wrong_of(self, *, transfers: bool) -> int:
        pairs = sum(tally.pairs for each, tally in self.tallies.items() if each.transfers is transfers)
        return pairs - self._right_of(transfers=transfers)

    def in_words(self) -> str:
        """A line."""
        of_each = ", ".join(f"{each} {tally.right} of {tally.pairs}" for each, tally in self.tallies.items())
        return (
            f"over the pairs flown ({self.flown}), the verdict was right for {self.right} of {self.pairs}: "
            f"{of_each}; {self.refused_though_harmless} refused though harmless, "
            f"{self.allowed_though_harmful} allowed though harmful; "
            f'"{Verdict.TRANSFER}" for all would have been right for {self.right_if_always_transfer}'
        )

    def as_json(self) -> dict[str, Any]:
        """The same, by names."""
        return {
            "flown": self.flown,
            "right": self.right,
            "pairs": self.pairs,
            "by_verdict": {each: tally._asdict() for each, tally in self.tallies.items()},
            "refused_though_harmless": self.refused_though_harmless,
            "allowed_though_harmful": self.allowed_though_harmful,
            "right_if_always_transfer": self.right_if_always_transfer,
            "wrong": None if self.wrong is None else [each._asdict() for each in self.wrong],
        }


MEASURED = TrackRecord(
    "`companion bench transfer`, docs/similarity.md",
    {
        Verdict.TRANSFER: Tally(12, 12),
        Verdict.SMALL_GAIN: Tally(40, 40),
        Verdict.TRAIN_ANEW: Tally(0, 8),
    },
)
"""Of `--flights` on that command's 600 flights with a network: 20 pairs in 3 conditions."""


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


def track_record(flown: str, verdicts: Mapping[Pair, Verdict], helped: Mapping[Pair, bool]) -> TrackRecord:
    """Right is a transfer that did not harm, and a refusal of one that would have.

    Args:
        flown: the flights that showed it.
        verdicts: given beforehand.
        helped: of `network_helped`; pairs without a verdict are left out.
    """
    right = {pair: verdicts[pair].transfers is helped[pair] for pair in helped if pair in verdicts}
    tallies = {each: _tally([right[pair] for pair in right if verdicts[pair] is each]) for each in Verdict}
    wrong = tuple(Mistake(*pair, verdicts[pair]) for pair in right if not right[pair])
    return TrackRecord(flown, tallies, wrong)


def _tally(right: Sequence[bool]) -> Tally:
    return Tally(sum(right), len(right))
