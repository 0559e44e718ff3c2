"""Two series of messages, number by number."""

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

from companion.recording.topics import Fields


@dataclass(slots=True)
class Difference:
    """Where a signal is not the same.

    Attributes:
        signal: topic and name, such as `/tracking u2.x`.
        first_s: when it first differs (s).
        count: in how many messages.
        largest: by how much at most; infinite where only one side has it.
    """

    signal: str
    first_s: float
    count: int = 0
    largest: float = 0.0


class Differences:
    """Collects them, by signal, in the order in which signals begin to differ."""

    def __init__(self) -> None:
        self._by_signal: dict[str, Difference] = {}

    def compare(self, topic: str, time_s: float, one: Fields, other: Fields) -> None:
        """Compare two messages of `topic` at `time_s` (s), to the last bit but for the sign of zero."""
        ones, others = dict(_numbers(one)), dict(_numbers(other))
        for name in sorted(ones.keys() | others.keys()):
            if ones.get(name) != others.get(name):
                difference = abs(ones.get(name, math.inf) - others.get(name, math.inf))
                self._note(f"{topic} {name}", time_s, difference)

    def missing(self, topic: str, time_s: float) -> None:
        """Only one side has a message of `topic` at `time_s` (s)."""
        self._note(topic, time_s, math.inf)

    def found(self) -> tuple[Difference, ...]:
        """What there is so far."""
        return tuple(self._by_signal.values())

    def _note(self, signal: str, time_s: float, difference: float) -> None:
        noted = self._by_signal.setdefault(signal, Difference(signal, time_s))
        noted.count += 1
        noted.largest = max(noted.largest, difference)


def _numbers(fields: Fields, prefix: str = "") -> Iterator[tuple[str, float]]:
    value: Any
    for name, value in fields.items():
        if isinstance(value, dict):
            yield from _numbers(value, f"{prefix}{name}.")
        elif isinstance(value, int | float):
            yield f"{prefix}{name}", float(value)
