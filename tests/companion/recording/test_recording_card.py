"""The card beside a flight log."""

import json
from pathlib import Path

import pytest

from companion.errors import InputError
from companion.recording.card import Card, read_card

SEGMENT = {"id": "a-pv", "start_unix_s": 1.0, "end_unix_s": 2.5}


def write(path: Path, content: object) -> None:
    path.write_text(json.dumps(content))


@pytest.mark.parametrize("suffix", [".tlog", ".tlog.xz", ".ulg"])
def test_a_card_is_found_beside_its_log_whatever_else_is_in_it(tmp_path: Path, suffix: str) -> None:
    write(tmp_path / "v1.16.json", {"system_id": 2, "segments": [SEGMENT | {"pilot": "x"}], "weather": {}})
    card = read_card(tmp_path / f"v1.16{suffix}")
    assert card.system_id == 2
    assert [segment.id for segment in card.segments] == ["a-pv"]
    assert card.segments[0].rms_m is None
    assert card.hover is None


def test_without_a_card_nothing_is_known(tmp_path: Path) -> None:
    assert read_card(tmp_path / "flight.tlog") == Card()


@pytest.mark.parametrize(
    ("content", "fault"),
    [
        ({"system_id": 0}, "system_id: "),
        ({"segments": [SEGMENT, SEGMENT | {"end_unix_s": 1.0}]}, "segments.1: .*start_unix_s must be before"),
        ({"segments": [SEGMENT | {"rms_m": "far"}]}, "segments.0.rms_m: "),
        ({"hover": {"start_unix_s": 1.0}}, "hover.end_unix_s: "),
        ([], "the file: "),
    ],
)
def test_a_wrong_card_is_refused_with_file_and_key(tmp_path: Path, content: object, fault: str) -> None:
    write(tmp_path / "flight.json", content)
    with pytest.raises(InputError, match=rf"flight\.json: {fault}"):
        read_card(tmp_path / "flight.tlog")


def test_what_is_no_json_is_refused(tmp_path: Path) -> None:
    (tmp_path / "flight.json").write_bytes(b"\xff{")
    with pytest.raises(InputError, match=r"flight\.json: the file: "):
        read_card(tmp_path / "flight.tlog")
