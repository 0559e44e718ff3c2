"""The note that a flight leaves behind when nobody knows how it ended."""

import threading
from pathlib import Path

import pytest

from companion.cli.unfinished import FlightNote
from companion.flight.states import FlightState

FOUND = (FlightState.STANDBY, FlightState.HOLDING)
FLOWN = (FlightState.STANDBY, FlightState.TAKING_OFF, FlightState.APPROACHING, FlightState.TRACKING)


def left_by(folder: Path, *states: FlightState) -> str:
    note = FlightNote(folder / "flights", 3, "star")
    for state in states:
        note.state(state).result()
    return FlightNote(folder / "flights", 3, "clef").former()


@pytest.mark.parametrize("end", [FlightState.HOLDING, FlightState.STANDBY])
def test_a_flight_that_ends_in_order_leaves_none(tmp_path: Path, end: FlightState) -> None:
    assert left_by(tmp_path, *FLOWN, end) == ""


@pytest.mark.parametrize("end", [FlightState.YIELDED, FlightState.FAILED, FlightState.DISCONNECTED])
def test_a_flight_that_ends_otherwise_leaves_it(tmp_path: Path, end: FlightState) -> None:
    assert left_by(tmp_path, *FLOWN, end) == "star"


@pytest.mark.parametrize("steps", [2, 3, 4])
def test_a_flight_that_is_cut_off_leaves_it(tmp_path: Path, steps: int) -> None:
    assert left_by(tmp_path, *FLOWN[:steps]) == "star"


def test_finding_a_vehicle_in_the_air_takes_no_note_away(tmp_path: Path) -> None:
    left_by(tmp_path, *FLOWN)
    assert left_by(tmp_path, *FOUND) == "star"


def test_vehicles_have_notes_of_their_own(tmp_path: Path) -> None:
    left_by(tmp_path, *FLOWN)
    assert FlightNote(tmp_path / "flights", 4, "star").former() == ""


@pytest.mark.parametrize("content", [b"", b"\xff\xfe", b"[1]", b"{}"])
def test_a_note_that_cannot_be_read_is_one_all_the_same(tmp_path: Path, content: bytes) -> None:
    (tmp_path / "in-flight-3.json").write_bytes(content)
    assert FlightNote(tmp_path, 3, "star").former() == "a flight"


def test_a_disk_that_fails_keeps_nobody_from_flying(tmp_path: Path) -> None:
    (tmp_path / "flights").write_text("a file where a folder should be")
    assert left_by(tmp_path / "flights", *FLOWN) == ""


def test_a_disk_that_hangs_keeps_nobody_from_flying(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    let_go, write = threading.Event(), Path.write_text

    def hanging(path: Path, data: str, encoding: str) -> int:
        assert let_go.wait(5.0)
        return write(path, data, encoding)

    monkeypatch.setattr(Path, "write_text", hanging)
    note = FlightNote(tmp_path, 3, "star")
    noted = [note.state(state) for state in (*FLOWN, FlightState.HOLDING)]
    assert not noted[-1].done()
    let_go.set()
    noted[-1].result()
    assert note.former() == ""
