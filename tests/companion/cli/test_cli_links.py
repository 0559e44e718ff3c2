"""Options of the link, in the commands that fly."""

from pathlib import Path

import pytest
from command_line import Run

COMMANDS = [["fly", "clef"], ["collect", "--output", "flight.mcap"]]


@pytest.mark.parametrize("command", COMMANDS, ids=lambda command: command[0])
def test_a_key_that_others_may_read_is_refused(
    companion: Run, command: list[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    key = tmp_path / "vehicle.key"
    key.write_text("00" * 32)
    key.chmod(0o644)
    result = companion(*command, "--connect", "sitl://bebop2", "--signing-key", str(key))
    assert result.status == 2
    assert "chmod 600" in result.err


@pytest.mark.parametrize("command", COMMANDS, ids=lambda command: command[0])
def test_the_built_in_vehicle_cannot_be_shared(
    companion: Run, command: list[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    result = companion(*command, "--connect", "sitl://bebop2", "--forward", "udpout://127.0.0.1:14550")
    assert result.status == 2
    assert "companion sitl" in result.err
