"""What a check found."""

from dataclasses import dataclass
from enum import StrEnum


class Severity(StrEnum):
    """What a finding means for a flight."""

    STOPS = "stops"
    """It would not take place, or not safely."""
    WARNS = "warns"
    """It can take place; somebody should know."""
    FINE = "fine"


@dataclass(frozen=True, slots=True)
class Finding:
    """One line of the report.

    Attributes:
        severity: what it means for a flight.
        topic: what was looked at, in a word or two.
        seen: what was seen.
        advice: what to do, with the exact parameter and value; empty where nothing is to be done.
    """

    severity: Severity
    topic: str
    seen: str
    advice: str = ""


def stops(topic: str, seen: str, advice: str) -> Finding:
    """A finding that stops a flight."""
    return Finding(Severity.STOPS, topic, seen, advice)


def warns(topic: str, seen: str, advice: str) -> Finding:
    """A finding to know of."""
    return Finding(Severity.WARNS, topic, seen, advice)


def fine(topic: str, seen: str) -> Finding:
    """All is well there."""
    return Finding(Severity.FINE, topic, seen)
