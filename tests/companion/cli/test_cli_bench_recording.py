"""A fixed slice of `companion bench recording`."""

import json
from pathlib import Path

from command_line import Run


def test_cuts_lose_at_most_the_last_second(companion: Run, tmp_path: Path) -> None:
    ran = companion("bench", "recording", "--cuts", 10, "--json", tmp_path / "cuts.json")
    assert ran.status == 0, ran.err
    told = json.loads((tmp_path / "cuts.json").read_text())
    assert told["unreadable"] == 0
    assert 0.0 < told["worst_loss_s"] <= 1.0
    assert "0 unreadable" in ran.out
