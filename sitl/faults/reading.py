"""Faults from a line of text, as commands and connection strings have them, or from a YAML file."""

from collections.abc import Sequence
from pathlib import Path
from typing import Annotated

from pydantic import BaseModel, ConfigDict, Field, TypeAdapter, ValidationError

from sitl import files
from sitl.errors import ConfigError
from sitl.faults.kinds import COMMON, KINDS, Fault

_FAULT: TypeAdapter[Fault] = TypeAdapter(Annotated[Fault, Field(discriminator="kind")])
FORM = "KIND:KEY=VALUE,KEY=VALUE, as in motor_weak:motor=2,effectiveness=0.6,after=takeoff,at_s=12"


def parse_fault(text: str) -> Fault:
    """The fault that a text such as "gust:north_m_s=8,after=setpoints,lasts_s=2" means.

    Raises:
        ConfigError: an unknown kind or key, or a value out of its range; names what there is.
    """
    kind, _, rest = text.strip().partition(":")
    if kind not in KINDS:
        raise ConfigError(
            f"fault {text!r}", "", f"{kind!r} is no kind of fault; there are {', '.join(KINDS)}"
        )
    values = {"kind": kind}
    for pair in filter(None, (part.strip() for part in rest.split(","))):
        key, equals, value = (part.strip() for part in pair.partition("="))
        if not equals or key == "kind" or key in values:
            raise ConfigError(f"fault {text!r}", "", f"{pair!r} is wrong here; the form is {FORM}")
        values[key] = value
    try:
        return _FAULT.validate_python(values)
    except ValidationError as error:
        raise ConfigError(f"fault {text!r}", *_complaint(error, kind)) from None


def parse_faults(texts: Sequence[str]) -> tuple[Fault, ...]:
    """`parse_fault` of each."""
    return tuple(map(parse_fault, texts))


def write_fault(fault: Fault) -> str:
    """The text that `parse_fault` reads as this fault, defaults left out."""
    given = fault.model_dump(mode="json", exclude_defaults=True, exclude={"kind"})
    return ":".join(filter(None, (fault.kind, ",".join(f"{key}={value}" for key, value in given.items()))))


class _Script(BaseModel):
    """A file of faults."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    name: str
    description: str = ""
    faults: list[Annotated[Fault, Field(discriminator="kind")]]


def load_faults(path: str | Path) -> tuple[Fault, ...]:
    """The faults of a YAML file: under the key `faults` a list, each with its `kind` and parameters.

    Raises:
        ConfigError: not found, or wrong, with file, key and reason.
    """
    return tuple(files.load(_Script, "faults", Path(path).absolute()).faults)


def describe_kinds() -> str:
    """A line for each kind: its parameters, and what it means."""
    lines = []
    for kind, model in KINDS.items():
        own = [
            name if field.is_required() else f"[{name}]"
            for name, field in model.model_fields.items()
            if name != "kind" and name not in COMMON
        ]
        lines.append(f"{':'.join(filter(None, (kind, ','.join(own))))}  {model.meaning}")
    return "\n".join(lines)


def _complaint(error: ValidationError, kind: str) -> tuple[str, str]:
    fault = error.errors(include_url=False)[0]
    key = ".".join(str(part) for part in fault["loc"] if part != kind)
    if fault["type"] == "extra_forbidden":
        known = [name for name in KINDS[kind].model_fields if name != "kind"]
        return key, f"{kind} has no such key; it has {', '.join(known)}"
    if fault["type"] == "missing":
        return key, f"missing; {kind} needs it"
    return key, f"{fault['msg']} (got {fault['input']!r})"
