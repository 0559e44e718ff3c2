"""A job that is stopped goes on where it was, and only with what belongs to it."""

from pathlib import Path

import pytest
from pydantic import BaseModel

from companion.errors import InputError
from companion.experiments.fingerprint import fingerprint
from companion.experiments.journal import Journal


class Row(BaseModel):
    number: int


def journal(file: Path, belongs_to: str = "a job", most: int = 10) -> Journal[Row]:
    return Journal(file, Row, belongs_to=belongs_to, most=most)


def numbers(of: Journal[Row]) -> list[int]:
    return [row.number for row in of.rows]


@pytest.fixture
def file(tmp_path: Path) -> Path:
    begun = journal(tmp_path / "job.flown")
    for number in range(3):
        begun.append(Row(number=number))
    return begun.file


def test_nothing_is_written_before_the_first_row(tmp_path: Path) -> None:
    assert numbers(journal(tmp_path / "none")) == []
    assert not (tmp_path / "none").exists()


def test_rows_are_there_again_and_more_follow(file: Path) -> None:
    again = journal(file)
    assert numbers(again) == [0, 1, 2]
    again.append(Row(number=3))
    assert numbers(journal(file)) == [0, 1, 2, 3]


@pytest.mark.parametrize("cut", range(1, 40))
def test_half_a_line_is_made_again(file: Path, cut: int) -> None:
    content = file.read_bytes()
    file.write_bytes(content[:-cut])
    kept = content[:-cut].count(b"\n") - 1
    if kept < 0:
        with pytest.raises(InputError, match="delete it"):
            journal(file)
        return
    again = journal(file)
    assert numbers(again) == list(range(kept))
    again.append(Row(number=7))
    assert numbers(journal(file)) == [*range(kept), 7]


def test_another_job_s_rows_are_refused(file: Path) -> None:
    with pytest.raises(InputError, match="other settings"):
        journal(file, belongs_to="another job")


def test_what_is_no_row_is_refused(file: Path) -> None:
    file.write_bytes(file.read_bytes().replace(b'"number":1', b'"number":"one"'))
    with pytest.raises(InputError, match="damaged"):
        journal(file)


def test_no_more_rows_than_the_job_has_are_read(file: Path) -> None:
    assert numbers(journal(file, most=2)) == [0, 1]


def test_a_folder_is_no_journal(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="cannot be read"):
        journal(tmp_path)


def test_the_fingerprint_tells_parts_apart() -> None:
    assert fingerprint([b"ab", b"c"]) == fingerprint([b"ab", b"c"]) != fingerprint([b"a", b"bc"])
