"""`companion replay`: the same bits when nothing changed, and where they differ when something did."""

import json
from pathlib import Path

import numpy as np
import pytest
from command_line import Run

from companion.flight import motion_history
from companion.recording import read_recording, write_recording


@pytest.fixture
def line(tmp_path: Path) -> Path:
    """A short trajectory: four seconds, two metres."""
    file = tmp_path / "line.csv"
    t = np.linspace(0.0, 4.0, 41)
    rows = [f"{time:.2f},{1.0 - np.cos(np.pi * time / 4.0):.4f},0,-2" for time in t]
    file.write_text("\n".join(["t,n,e,d", *rows]))
    return file


DATA = Path(__file__).parents[2] / "data"
VEHICLE = "sitl://bebop2?conditions=realistic&seed=5"


@pytest.mark.parametrize("how", [("--model", "ardrone2"), ("--strategy", "baseline", "--yaw", "path")])
def test_a_flight_replays_to_the_last_bit(
    companion: Run, line: Path, tmp_path: Path, how: tuple[str, ...]
) -> None:
    record = tmp_path / "flight.mcap"
    assert companion("fly", line, "--connect", VEHICLE, *how, "--record", record).status == 0
    ran = companion("replay", record)
    assert ran.status == 0, ran.err
    assert "control steps: the same to the last bit" in ran.out

    content = record.read_bytes()
    record.write_bytes(content[: len(content) * 2 // 3])
    ran = companion("replay", record)
    assert ran.status == 0, ran.err
    assert "was cut short" in ran.out


def test_a_flight_that_is_clipped_and_falls_back_replays_to_the_last_bit(
    companion: Run, line: Path, tmp_path: Path
) -> None:
    guard, record = tmp_path / "guard.yaml", tmp_path / "flight.mcap"
    guard.write_text(
        "velocity_change_m_s2: 1.0\nfence: {circles: [{radius_m: 2.05}]}\n"
        "watchdogs: {unpredicted_m: {limit: 0.001, lasts_s: 0.0}}\n"
    )
    flown = companion("fly", line, "--connect", VEHICLE, "--record", record, "--guard", guard)
    assert flown.status == 0, flown.err
    for said in ("falling back on the plain strategy", "acceleration limited"):
        assert said in flown.out
    ran = companion("replay", record)
    assert ran.status == 0, ran.err
    assert "control steps: the same to the last bit" in ran.out


def test_what_changed_is_shown(
    companion: Run, line: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    record, told = tmp_path / "flight.mcap", tmp_path / "replay.json"
    assert companion("fly", line, "--connect", VEHICLE, "--record", record).status == 0
    monkeypatch.setattr(motion_history, "RECENT_S", 0.12)
    ran = companion("replay", record, "--json", told)
    assert ran.status == 1
    result = json.loads(told.read_text())
    assert result["whole"]
    signals = {difference["signal"]: difference for difference in result["differences"]}
    assert "/tracking u2.x" in signals
    assert "/tracking u1.x" not in signals
    moved = signals["/reference position.x"]
    assert 0.0 < moved["largest"] < 1.0
    assert 0 < moved["count"] < result["steps"]
    assert moved["first_s"] > result["start_s"]
    assert "/reference position.x" in ran.out


def test_another_network_is_refused(companion: Run, line: Path, tmp_path: Path) -> None:
    record = tmp_path / "flight.mcap"
    assert companion("fly", line, "--connect", VEHICLE, "--model", "ardrone2", "--record", record).status == 0
    ran = companion("replay", record, "--model", "x500")
    assert ran.status == 2
    assert "x500 is not the model that was flown" in ran.err


def test_what_holds_no_control_loop_is_refused(companion: Run, tmp_path: Path) -> None:
    write_recording(read_recording(DATA / "px4_sih_excerpt.tlog.xz"), tmp_path / "series.mcap")
    ran = companion("replay", tmp_path / "series.mcap")
    assert ran.status == 2
    assert "no control loop in it" in ran.err
