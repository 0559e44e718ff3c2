"""`companion report`: the same figures as the flight gave, from its log, whole or cut short."""

import json
import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from command_line import Run
from pymavlink import mavutil

from companion.recording import read_recording

DATA = Path(__file__).parents[2] / "data"


@pytest.fixture
def line(tmp_path: Path) -> Path:
    """A trajectory of four seconds, two metres."""
    line = tmp_path / "line.csv"
    t = np.linspace(0.0, 4.0, 41)
    rows = [f"{time:.2f},{1.0 - math.cos(math.pi * time / 4.0):.4f},0,-2" for time in t]
    line.write_text("\n".join(["t,n,e,d", *rows]))
    return line


@pytest.fixture
def flown(companion: Run, line: Path, tmp_path: Path) -> Path:
    """The recording of a flight along it; its result is beside it."""
    record = tmp_path / "flight.mcap"
    vehicle = "sitl://bebop2?conditions=realistic&seed=5"
    ran = companion("fly", line, "--connect", vehicle, "--record", record, "--json", tmp_path / "told.json")
    assert ran.status == 0, ran.err
    return record


def test_flights_are_shown_from_their_logs(companion: Run, flown: Path, tmp_path: Path) -> None:
    content = flown.read_bytes()
    cut = flown.with_name("cut.mcap")
    cut.write_bytes(content[: len(content) * 17 // 20])
    ran = companion("report", flown, cut, "--output", tmp_path / "page", "--json", tmp_path / "report.json")
    assert ran.status == 0, ran.err
    told = json.loads((tmp_path / "told.json").read_text())
    whole, part = json.loads((tmp_path / "report.json").read_text())["flights"]
    assert whole["rms_m"] == pytest.approx(told["rms_m"], rel=1e-6)
    assert whole["max_m"] == pytest.approx(told["max_m"], rel=1e-6)
    assert whole["duration_s"] == pytest.approx(told["duration_s"], abs=0.05)
    assert 1.0 < part["duration_s"] < whole["duration_s"]
    assert (whole["whole"], part["whole"]) == (True, False)
    assert f"{cut} was cut short" in ran.out
    assert f"{flown} was cut short" not in ran.out
    page = (tmp_path / "page" / "index.html").read_text()
    for file in (tmp_path / "page").glob("*.png"):
        assert file.name in page
    assert len(list((tmp_path / "page").glob("*.png"))) == 4
    assert "tracking line for" in page
    assert f"companion fly {flown.with_name('line.csv')} " in page
    assert "<dt>firmware</dt><dd>1.16.0</dd>" in page
    assert "cut.mcap was cut short" in page
    assert "gp (flight)" in ran.out


def test_the_raw_link_is_a_telemetry_log(flown: Path) -> None:
    """As MAVProxy reads it, and as we do ourselves."""
    tlog = flown.with_suffix(".tlog")
    log = mavutil.mavlink_connection(str(tlog))
    kinds: dict[tuple[int, str], int] = {}
    stamps = []
    while (message := log.recv_msg()) is not None:
        source = message.get_srcComponent(), message.get_type()
        kinds[source] = kinds.get(source, 0) + 1
        stamps.append(message._timestamp)
    log.close()
    assert not any(kind == "BAD_DATA" for _, kind in kinds)
    ours, vehicle = 191, 1
    sent = kinds[ours, "SET_POSITION_TARGET_LOCAL_NED"]
    recording, again = read_recording(flown), read_recording(tlog)
    assert sent == len(recording.references.time_s)
    assert kinds[vehicle, "LOCAL_POSITION_NED"] >= len(recording.states.time_s)
    assert stamps == sorted(stamps)
    assert len(again.references.time_s) == sent
    np.testing.assert_allclose(again.references.position, recording.references.position, atol=1e-5)


def test_flights_are_told_apart_on_a_narrow_terminal(companion: Run, flown: Path, tmp_path: Path) -> None:
    names = [f"20260501T123456Z-line-gp-{number}" for number in (1, 2)]
    paths = [flown.with_name(f"{name}.mcap") for name in names]
    for path in paths:
        path.write_bytes(flown.read_bytes())
    ran = companion("report", *paths, "--output", tmp_path / "page")
    assert ran.status == 0, ran.err
    assert "…" not in ran.out


def test_a_log_of_another_program_is_shown_by_what_was_sent(companion: Run, tmp_path: Path) -> None:
    log = DATA / "px4_sih_excerpt.tlog.xz"
    ran = companion("report", log, "--output", tmp_path / "page")
    assert ran.status == 0, ran.err
    assert "setpoints" in ran.out
    assert "<h2>px4_sih_excerpt</h2>" in (tmp_path / "page" / "index.html").read_text()
    assert (tmp_path / "page" / "01-path.png").stat().st_size > 1000


def test_a_flight_that_never_tracked_is_named(companion: Run, flown: Path) -> None:
    flown.write_bytes(flown.read_bytes()[:30_000])
    ran = companion("report", flown)
    assert ran.status == 2
    assert f"{flown}: ends before anything was tracked" in ran.err


def test_a_file_without_a_flight_does_not_keep_the_others_from_being_shown(
    companion: Run, flown: Path, tmp_path: Path
) -> None:
    empty, told = tmp_path / "empty.mcap", tmp_path / "report.json"
    empty.write_bytes(b"")
    ran = companion("report", empty, flown, "--output", tmp_path / "page", "--json", told)
    assert ran.status == 0, ran.err
    assert f"left out: {empty}: " in ran.out
    result = json.loads(told.read_text())
    assert [each["file"] for each in result["flights"]] == [str(flown)]
    assert len(result["left_out"]) == 1


def test_only_what_was_tracked_counts(companion: Run, line: Path, tmp_path: Path) -> None:
    """A watchdog ends the flight: how far the vehicle is from the trajectory while it lands is no error."""
    shown = fly_and_report(companion, line, tmp_path, "gps_lost:at_s=12")
    assert 1.0 < shown["duration_s"] < 3.0
    assert shown["max_m"] < 0.1


def test_what_was_tracked_before_a_fall_back_counts_too(companion: Run, line: Path, tmp_path: Path) -> None:
    guard = tmp_path / "guard.yaml"
    guard.write_text("watchdogs: {off_course_m: {limit: 0.5, lasts_s: 0.1, action: fall back}}")
    gust = "gust:north_m_s=20,at_s=13.5,lasts_s=1"
    shown = fly_and_report(companion, line, tmp_path, gust, "--guard", guard)
    assert "falling back" in (tmp_path / "page" / "index.html").read_text()
    assert shown["duration_s"] == pytest.approx(4.4, abs=0.1)


def fly_and_report(companion: Run, line: Path, folder: Path, fault: str, *options: object) -> Any:
    record, told = folder / "flight.mcap", folder / "report.json"
    companion("fly", line, "--connect", f"sitl://bebop2?fault={fault}", "--record", record, *options)
    ran = companion("report", record, "--output", folder / "page", "--json", told)
    assert ran.status == 0, ran.err
    return json.loads(told.read_text())["flights"][0]
