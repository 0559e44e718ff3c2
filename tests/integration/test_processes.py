"""`companion sitl` and `companion fly` as a newcomer runs them: two processes, UDP between them, Ctrl-C."""

import signal
from pathlib import Path

import pytest
from processes import companion, line_with

from companion.flight.replay import replay
from companion.recording import read_recording

SYSTEM_ID = 97  # ports of its own, away from those of a simulator that a developer may have running
PORT = 14540 + SYSTEM_ID - 1


def recording_in(folder: Path) -> Path:
    (path,) = folder.glob("*-star-gp.mcap")
    return path


@pytest.mark.realtime
@pytest.mark.parametrize("stop", [signal.SIGINT, signal.SIGTERM])
async def test_a_flight_that_is_stopped_leaves_the_vehicle_in_a_hold(
    stop: signal.Signals, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("IMPROMPTU_LOG_DIR", str(tmp_path))
    serve = ("sitl", "--system-id", str(SYSTEM_ID), "--speed", "2")
    fly = ("fly", "star", "--connect", f"udpin://127.0.0.1:{PORT}")
    async with companion(*serve) as vehicle, companion(*fly) as flight:
        await line_with("tracking star", flight)
        flight.send_signal(stop)
        await line_with("the vehicle holds", flight)
        await line_with("stopped", flight)
        assert await flight.wait() == 130
        path = recording_in(tmp_path)
        assert read_recording(path).events[-1][1] == "the vehicle holds"
        replayed = replay(path, lambda technique: None)
        assert replayed.steps > 100
        assert not replayed.differences
        await line_with("mode OFFBOARD", vehicle)
        await line_with("mode HOLD", vehicle)
        vehicle.send_signal(stop)
        await line_with("ended", vehicle)
        assert await vehicle.wait() == 0


@pytest.mark.realtime
async def test_a_flight_that_is_killed_leaves_its_recording(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("IMPROMPTU_LOG_DIR", str(tmp_path))
    serve = ("sitl", "--system-id", str(SYSTEM_ID), "--speed", "2")
    fly = ("fly", "star", "--connect", f"udpin://127.0.0.1:{PORT}")
    async with companion(*serve), companion(*fly) as flight:
        await line_with("tracking star", flight)
        flight.kill()
        await flight.wait()
    path = recording_in(tmp_path)
    recording = read_recording(path)
    assert "cut short" in recording.events[-1][1]
    assert any(text == "settling" for _, text in recording.events)
    assert len(read_recording(path.with_suffix(".tlog")).references.time_s) > 100
