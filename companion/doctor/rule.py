"""What to make of a parameter's value: a rule, and the common kinds of it."""

from collections.abc import Callable, Container, Mapping
from typing import TypeAlias

from companion.doctor.finding import Finding, fine, warns
from companion.doctor.observation import Observation
from companion.link.parameter_encoding import Number

Rule: TypeAlias = Callable[[str, Number, Observation], Finding]
"""From a parameter's name and value, and all that was seen, to what they mean for a flight."""


def at_least(least: float, unit: str, what: str, *, instead: str) -> Rule:
    """A limit that trajectories run into when it is lower than `least`."""

    def judged(name: str, value: Number, seen: Observation) -> Finding:
        told = f"{what} {value:g} {unit}"
        if value < least:
            return warns(name, f"{told}: trajectories will lag", f"set {name} {instead}, or fly slower")
        return fine(name, told)

    return judged


def one_of(names: Mapping[int, str], what: str, *, unsafe: Container[Number] = (), instead: str = "") -> Rule:
    """A choice, some of which are not what one wants."""

    def judged(name: str, value: Number, seen: Observation) -> Finding:
        told = f"{what}: {names.get(int(value), f'choice {value:g}')}"
        return warns(name, told, f"set {name} {instead}") if value in unsafe else fine(name, told)

    return judged
