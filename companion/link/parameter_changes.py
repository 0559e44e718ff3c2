"""What differs between two sets of parameters, and what of a file a vehicle would take."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from companion.errors import InputError
from companion.link.parameter import same_value
from companion.link.parameter_encoding import Number, Parameter
from companion.link.parameter_file import FileParameter, written

_TOLD = 10


@dataclass(frozen=True, slots=True)
class Difference:
    """A parameter that two sets have with different values; None where a set has it not."""

    name: str
    before: Number | None
    after: Number | None


def differences(before: Mapping[str, Number], after: Mapping[str, Number]) -> Sequence[Difference]:
    """What differs by more than the precision of a float32, by name."""
    found = (Difference(name, before.get(name), after.get(name)) for name in sorted({*before, *after}))
    return [each for each in found if not _same(each)]


def changes_to(
    vehicle: Mapping[str, Parameter], wanted: Iterable[FileParameter], file: Path
) -> Sequence[Parameter]:
    """What is to be set so that the vehicle has the values that are wanted, in the vehicle's types.

    Raises:
        InputError: the vehicle has no such parameter, or has it in another type; tells of all of them.
    """
    wanted = tuple(wanted)
    problems = [problem for each in wanted if (problem := _problem(vehicle.get(each.name), each))]
    if problems:
        more = f"; and {len(problems) - _TOLD} more" if len(problems) > _TOLD else ""
        told = "; ".join(problems[:_TOLD]) + more
        raise InputError(f"{file}: {told}. Nothing was set: mend these lines, or take them out")
    settings = (_setting(vehicle[each.name], each.value) for each in wanted)
    return [each for each in settings if not same_value(vehicle[each.name].value, each.value)]


def _same(each: Difference) -> bool:
    return each.before is not None and each.after is not None and same_value(each.before, each.after)


def _problem(own: Parameter | None, wanted: FileParameter) -> str | None:
    """Why the vehicle cannot take it."""
    where = f"line {wanted.line}"
    if own is None:
        return f"{where}: the vehicle has no parameter {wanted.name}"
    if wanted.type not in (None, own.type):
        return f"{where}: {wanted.name} is {own.type.name} on the vehicle, not {wanted.type.name}"
    if not own.type.holds(wanted.value):
        return f"{where}: {wanted.name} is {own.type.name}, which {written(wanted.value)} is not"
    return None


def _setting(own: Parameter, value: float) -> Parameter:
    return Parameter(own.name, int(value) if own.type.is_integer else value, own.type)
