"""Parameter files: QGroundControl's, read and written; those of MAVProxy and Mission Planner, read.

QGroundControl's has tabs between vehicle id, component id, name, value and type (MAV_PARAM_TYPE); the others
have a name and a value, with spaces or a comma between. # begins a comment.
"""

import re
from collections.abc import Iterable, Sequence
from pathlib import Path

from pydantic import BaseModel, ConfigDict, Field, ValidationError

from companion.bounded_file import read_bounded
from companion.errors import InputError
from companion.link.dialect import mavlink
from companion.link.parameter_encoding import Number, Parameter, ParameterType

LARGEST_FILE_BYTES = 1_000_000
"""Two thousand parameters take a tenth of it."""

_QGC_COLUMNS = 5
_TYPES: dict[object, ParameterType] = {str(kind.value): kind for kind in ParameterType}
_SEPARATOR = re.compile(r"\s*[,=]\s*|\s+")


class FileParameter(BaseModel):
    """One line of a parameter file.

    Attributes:
        line: its number, from 1.
        name: of the parameter.
        value: as it is written.
        type: of the parameter, where the file tells it.
        component: whose it is, where the file tells it.
    """

    model_config = ConfigDict(frozen=True)

    line: int
    name: str = Field(pattern=r"^[A-Za-z0-9_]{1,16}$")
    value: float
    type: ParameterType | None = None
    component: int | None = Field(None, ge=0, le=255)

    @property
    def is_of_autopilot(self) -> bool:
        """Whether it is none of a camera, a gimbal or another component."""
        return self.component in (None, mavlink.MAV_COMP_ID_AUTOPILOT1)


def read_parameter_file(path: Path) -> Sequence[FileParameter]:
    """The parameters in a file of any of the formats.

    Raises:
        InputError: it cannot be read, has a line that is no parameter, or has one twice.
    """
    try:
        text = read_bounded(path, LARGEST_FILE_BYTES).decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise InputError(f"{path}: not a text file") from error
    found: dict[tuple[int | None, str], FileParameter] = {}
    for number, line in enumerate(text.splitlines(), start=1):
        content = line.partition("#")[0].strip()
        if not content:
            continue
        parameter = _parameter(path, number, content)
        key = (parameter.component, parameter.name)
        if key in found:
            raise InputError(
                f"{path}, line {number}: {parameter.name} is in line {found[key].line} too: keep one"
            )
        found[key] = parameter
    if not found:
        raise InputError(f"{path}: no parameters in it: a line is a name and a value")
    return tuple(found.values())


def write_parameter_file(
    path: Path, parameters: Iterable[Parameter], *, system_id: int, about: Iterable[str]
) -> None:
    """Write a file that QGroundControl reads; `about` are comments, such as `Stack: PX4 Pro`."""
    lines = [
        f"# Onboard parameters for Vehicle {system_id}",
        "#",
        *(f"# {each}" for each in about),
        "#",
        "# Vehicle-Id Component-Id Name Value Type",
    ]
    for each in sorted(parameters, key=lambda parameter: parameter.name):
        columns = (
            *(system_id, mavlink.MAV_COMP_ID_AUTOPILOT1),
            *(each.name, written(each.value), each.type.value),
        )
        lines.append("\t".join(map(str, columns)))
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")


def written(value: Number) -> str:
    """A value with as many digits as a float32 needs to be read back exactly."""
    return str(value) if isinstance(value, int) else f"{value:.9g}"


def _parameter(path: Path, number: int, content: str) -> FileParameter:
    columns = content.split("\t")
    if len(columns) == _QGC_COLUMNS:
        _, component, name, value, kind = (column.strip() for column in columns)
        fields: dict[str, object] = {"component": component, "name": name, "value": value, "type": kind}
    else:
        columns = _SEPARATOR.split(content)
        if len(columns) != 2:
            raise InputError(
                f"{path}, line {number}: {content[:60]!r} is no name and value, nor a QGroundControl line"
            )
        fields = {"name": columns[0], "value": columns[1]}
    if fields.get("type") in _TYPES:
        fields["type"] = _TYPES[fields["type"]]
    try:
        return FileParameter.model_validate({"line": number, **fields})
    except ValidationError as error:
        first = error.errors()[0]
        raise InputError(f"{path}, line {number}: {first['loc'][0]}: {first['msg']}") from error
