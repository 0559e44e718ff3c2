"""What a flight with a network says of its source and its target, once it is over."""

import json
from pathlib import Path

import pytest
from command_line import Run

from companion.recording.mcap_reader import Message, read_items
from companion.recording.topics import EVENTS


def test_lemma_1_is_in_the_recording_of_a_flight(companion: Run, tmp_path: Path) -> None:
    record = tmp_path / "flight.mcap"
    ran = companion(
        *("fly", "clef", "--connect", "sitl://bebop2", "--model", "ardrone2", "--land", "--record", record),
    )
    assert ran.status == 0, ran.err
    assert "similarity to ardrone2: north S1 " in ran.out
    (event,) = (
        item.fields
        for item in read_items(record)
        if isinstance(item, Message) and item.topic == EVENTS and item.fields["name"] == "similarity"
    )
    assert event["message"] in ran.out
    data = json.loads(event["data"])
    assert data["source"] == "ardrone2"
    assert set(data) == {"source", "north", "down"}
    for axis in ("north", "down"):
        terms = data[axis]
        assert terms["lemma_1_vacuous"] is True
        assert terms["lemma_1_alpha"] == 0.0
        if terms["l1"] is None:  # without bound
            assert terms["beta_4"] is None
        else:
            assert terms["beta_4"] == pytest.approx(1.0 - terms["l1"] * terms["inverse_state_gain"])
            assert terms["beta_4"] <= 0.0
        assert 0.0 < terms["s2_norm"] < 10.0


def test_a_flight_without_a_network_has_no_source(companion: Run) -> None:
    ran = companion("fly", "clef", "--size", 1, "--connect", "sitl://bebop2", "--strategy", "gp")
    assert ran.status == 0, ran.err
    assert "similarity" not in ran.out
