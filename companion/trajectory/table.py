"""Reading a table of numbers from text, as spreadsheets, scripts and plotting tools write it."""

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from jaxtyping import Float

from companion.arrays import Array
from companion.bounded_file import read_bounded
from companion.errors import InputError

LARGEST_FILE_BYTES = 20_000_000
LARGEST_NUMBER = 1e12


@dataclass(frozen=True, eq=False)
class Table:
    """The numbers of a file.

    Attributes:
        columns: names from the header, in lower case; None without a header.
        values: the numbers, a row of the file each.
        lines: number of the line in the file, for each row.
        first_line: number of the line with the header, or else with the first row.
    """

    columns: tuple[str, ...] | None
    values: Float[Array, "rows columns"]
    lines: tuple[int, ...]
    first_line: int


def read_table(path: Path) -> Table:
    """Read a table with columns separated by commas, semicolons, tabs or spaces.

    The first row may be a header; `#` starts a comment. With semicolons, numbers may have decimal commas.

    Raises:
        InputError: unreadable, no rows, rows of different lengths, or something other than finite numbers.
    """
    rows = list(_rows(_text(path)))
    if not rows:
        raise InputError(f"{path}:1: the file is empty; expected rows of numbers")
    separator = next((mark for mark in ";\t," if mark in rows[0][1]), None)
    split = [(line, _fields(row, separator)) for line, row in rows]
    columns = None
    if not any(_is_number(field) for field in split[0][1]):
        columns = tuple(name.lower() for name in split.pop(0)[1])
    width = len(columns or split[0][1])
    values = [_numbers(path, line, fields, width) for line, fields in split]
    lines = tuple(line for line, _ in split)
    return Table(columns, np.array(values).reshape(len(values), width), lines, first_line=rows[0][0])


def _text(path: Path) -> str:
    content = read_bounded(path, LARGEST_FILE_BYTES)
    try:
        return content.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        line = content[: error.start].count(b"\n") + 1
        raise InputError(f"{path}:{line}: not UTF-8 text; save the file as plain CSV") from error


def _rows(text: str) -> Iterator[tuple[int, str]]:
    """The rows that hold something, with their line numbers."""
    for line, row in enumerate(text.replace("\r\n", "\n").replace("\r", "\n").split("\n"), start=1):
        content = row.partition("#")[0].strip(" ")
        if content.strip():
            yield line, content


def _fields(row: str, separator: str | None) -> list[str]:
    fields = [field.strip().strip('"') for field in row.split(separator)]
    return [field.replace(",", ".") for field in fields] if separator == ";" else fields


def _is_number(field: str) -> bool:
    try:
        float(field)
    except ValueError:
        return False
    return True


def _numbers(path: Path, line: int, fields: list[str], width: int) -> list[float]:
    if len(fields) != width:
        raise InputError(f"{path}:{line}: {len(fields)} columns where {width} were expected")
    for field in fields:
        if not _is_number(field):
            raise InputError(f"{path}:{line}: {field[:40]!r} is not a number")
        if not abs(float(field)) <= LARGEST_NUMBER:
            raise InputError(f"{path}:{line}: {field[:40]} is not a number that can be flown")
    return [float(field) for field in fields]
