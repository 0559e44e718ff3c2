"""`companion similarity`, on flights of simulated vehicles."""

import json
from pathlib import Path

import numpy as np
import pytest
from simulated_recording import HOVER, fly
from typer.testing import CliRunner

from companion.arrays import Vec3
from companion.cli import similarity as command
from companion.cli.app import app
from companion.errors import InputError
from companion.recording import Recording, read_recording, write_recording
from companion.similarity.track_record import MEASURED
from sitl.vehicle import load_vehicle

PULSATION = np.array(((1.1, 0.5), (0.9, 1.7), (0.7, 1.3)))
QUICK = 3.1 * PULSATION[:, ::-1]


def weave(time_s: float) -> tuple[Vec3, Vec3]:
    """Slow and quick sinusoids on all axes, from rest."""
    slow, quick = PULSATION * time_s, QUICK * time_s
    position = (1.0 - np.cos(slow)).sum(axis=1) + 0.1 * (1.0 - np.cos(quick)).sum(axis=1)
    velocity = (PULSATION * np.sin(slow)).sum(axis=1) + 0.1 * (QUICK * np.sin(quick)).sum(axis=1)
    return HOVER[:3] + position, velocity


@pytest.fixture(scope="module")
def flights(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("flights")
    for name in ("ardrone2", "bebop2"):
        write_recording(fly(load_vehicle(name), 30.0, path=weave), folder / f"{name}.mcap")
    return folder


def similarity(*arguments: str | Path) -> str:
    """What the command prints."""
    result = CliRunner().invoke(app, ["similarity", *map(str, arguments)])
    if result.exception is not None:
        raise result.exception
    return result.output


def test_two_data_sets(flights: Path) -> None:
    result = flights / "similarity.json"
    printed = similarity(flights / "ardrone2.mcap", flights / "bebop2.mcap", "--json", result)
    assert "ν-gap" in printed
    assert "Lemma 1 is vacuous" in printed
    assert "verdict: " in printed
    told = json.loads(result.read_text())
    assert told["verdict"] in ("transfer", "transfer with small gain", "train anew")
    north = told["axes"]["north"]
    gap = north["figures"]["nu_gap"]
    assert 0.0 <= gap["low"] <= gap["high"] <= 1.0
    assert north["lemma_1_vacuous"] is True
    assert north["source"]["minimum_phase"] is True
    assert north["figures"]["beta_1"]["low"] is north["figures"]["beta_1"]["high"] is None
    assert MEASURED.in_words() in printed
    assert told["record"]["right"] == MEASURED.right
    assert told["record"]["wrong"] is None


def test_a_vehicle_beside_itself_is_a_transfer(flights: Path) -> None:
    printed = similarity(flights / "bebop2.mcap", flights / "bebop2.mcap")
    assert "verdict: transfer (in 100%" in printed


def test_flights_of_ones_own_replace_the_record(flights: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def recorded(vehicle: str, conditions: str, seed: int) -> Recording:
        return read_recording(flights / f"{vehicle}.mcap")

    monkeypatch.setattr(command, "_simulated", recorded)
    mcap = flights / "bebop2.mcap"
    common = {"target": "bebop2", "trajectory": "star", "conditions": "ideal"}
    own, result = flights / "pairs.json", flights / "own.json"
    own.write_text(
        json.dumps(
            {
                "rows": [
                    common | {"source": None, "strategy": "gp", "rms_m": 0.05},
                    common | {"source": "ardrone2", "strategy": "dnn+gp", "rms_m": 0.5},
                ]
            }
        )
    )
    printed = similarity(mcap, mcap, "--flights", own, "--json", result)
    assert f"over the pairs flown ({own})" in printed
    assert MEASURED.in_words() not in printed
    record = json.loads(result.read_text())["record"]
    assert (record["pairs"], record["right_if_always_transfer"]) == (1, 0)
    wrong = [{key: each[key] for key in ("source", "target", "conditions")} for each in record["wrong"]]
    assert wrong in ([], [{"source": "ardrone2", "target": "bebop2", "conditions": "ideal"}])
    assert record["right"] + len(wrong) == 1


def test_help_has_an_example() -> None:
    assert "companion similarity ardrone2.mcap bebop2.mcap" in similarity("--help")


@pytest.mark.parametrize("name", ["no_such.mcap", "no_such_vehicle", "no_such.safetensors"])
def test_what_is_not_there_is_named(flights: Path, name: str) -> None:
    with pytest.raises(InputError, match=name.removesuffix(".safetensors").removesuffix(".mcap")):
        similarity(name, flights / "bebop2.mcap")


def test_a_file_of_other_flights_is_refused(flights: Path) -> None:
    other = flights / "other.json"
    other.write_text("{}")
    mcap = flights / "bebop2.mcap"
    with pytest.raises(InputError, match="rows"):
        similarity(mcap, mcap, "--flights", other)
