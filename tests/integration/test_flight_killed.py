"""`kill -9` in the middle of a flight: the vehicle holds by itself, and is taken over only by `--resume`."""

import asyncio
import signal
from pathlib import Path

import numpy as np
import pytest
from processes import companion, line_with

from companion.recording import read_recording

SYSTEM_ID = 96
PORT = 14540 + SYSTEM_ID - 1
SERVE = ("sitl", "--system-id", str(SYSTEM_ID))
FLY = ("fly", "star", "--connect", f"udpin://127.0.0.1:{PORT}", "--strategy", "baseline")


@pytest.mark.realtime
async def test_a_killed_flight_is_resumed_only_when_asked(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("IMPROMPTU_LOG_DIR", str(tmp_path))
    async with companion(*SERVE) as vehicle:
        async with companion(*FLY) as flight:
            await line_with("tracking star", flight)
            await asyncio.sleep(3.0)  # until it is somewhere along it
            flight.send_signal(signal.SIGKILL)
            await flight.wait()
        await line_with("mode POSCTL", vehicle)
        async with companion(*FLY) as flight:
            said = await line_with("is in the air, armed, in POSCTL", flight)
            assert "star was cut off there" in said
            assert "--resume" in said
            assert await flight.wait() == 1
        async with companion(*FLY, "--resume", "--land") as flight:
            resumed_s = float((await line_with("resuming star at", flight)).split()[-2])
            assert resumed_s > 1.0  # not at the start again
            await line_with("RMS", flight)
            assert await flight.wait() == 0
        await line_with("mode OFFBOARD", vehicle)
        await line_with("mode LAND", vehicle)
    assert_resumed(tmp_path)


def assert_resumed(folder: Path) -> None:
    """One recording that was cut short, one of nothing, and one that goes on where the vehicle held."""
    assert not list(folder.glob("in-flight-*"))
    cut_off, refused, resumed = sorted(folder.glob("*.mcap"))
    left = read_recording(cut_off)
    assert "cut short" in left.events[-1][1]
    assert not len(read_recording(refused.with_suffix(".tlog")).references.time_s)
    went_on = read_recording(resumed)
    sent = went_on.references.position[0]
    assert np.linalg.norm(sent - went_on.states.position[0]) < 0.3
