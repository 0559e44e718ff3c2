"""What a long job has done so far, row by row in a file, so that it goes on where it was stopped."""

from pathlib import Path
from typing import Generic, TypeVar

from pydantic import BaseModel, ValidationError

from companion.errors import InputError

Row = TypeVar("Row", bound=BaseModel)

_LONGEST_LINE = 4096
"""Bytes; a row of a benchmark takes five hundred."""


class Journal(Generic[Row]):
    """Rows in the order in which they were made, one line each below a line that says what they belong to.

    Attributes:
        file: where; it is there from the first row on.
        rows: what an earlier run has left, and what was added since.

    Raises:
        InputError: the file cannot be read or written, is damaged, or belongs to another job.
    """

    def __init__(self, file: Path, row_type: type[Row], *, belongs_to: str, most: int) -> None:
        self.file = file
        self._belongs_to = belongs_to
        self.rows: list[Row] = []
        if file.exists():
            self._take_up(row_type, most)

    def append(self, row: Row) -> None:
        """Add a row, which is in the file when this returns."""
        try:
            with self.file.open("a", encoding="utf-8") as lines:
                if not self.rows:
                    lines.write(f"{self._belongs_to}\n")
                lines.write(f"{row.model_dump_json()}\n")
        except OSError as error:
            raise InputError(f"{self.file}: cannot be written: {error.strerror}") from error
        self.rows.append(row)

    def _take_up(self, row_type: type[Row], most: int) -> None:
        try:
            with self.file.open("r+b") as file:
                first, *lines = file.read((most + 1) * _LONGEST_LINE).splitlines(keepends=True) or [b""]
                if first.rstrip() != self._belongs_to.encode():
                    raise InputError(
                        f"{self.file}: was begun with other settings, or by another version of the program: "
                        "delete it to begin anew, or give another --json"
                    )
                # A run that was killed may have left half a line.
                whole = [line for line in lines[:most] if line.endswith(b"\n")]
                self.rows = [row_type.model_validate_json(line) for line in whole]
                file.truncate(len(first) + sum(map(len, whole)) if whole else 0)
        except ValidationError as error:
            raise InputError(f"{self.file}: damaged: delete it to begin anew") from error
        except OSError as error:
            raise InputError(f"{self.file}: cannot be read and written: {error.strerror}") from error
