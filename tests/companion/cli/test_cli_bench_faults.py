import json
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from command_line import Run


def test_the_command_writes_figures_and_page(companion: "Run", tmp_path: Path) -> None:
    file, page = tmp_path / "faults.json", tmp_path / "faults.md"
    wanted = ("--only", "reboot", "--phases", "takeoff", "--seeds", 1)
    ran = companion("bench", "faults", *wanted, "--json", file, "--markdown", page)
    assert ran.status == 0
    result = json.loads(file.read_text())
    assert result["summary"]["flights"] == 2
    assert [(row["kind"], row["vehicle"]) for row in result["rows"]] == [
        ("reboot", "bebop2"),
        ("reboot", "arducopter_sitl"),
    ]
    assert "never: all rotors stand still" in page.read_text()
    assert sorted(path.name for path in tmp_path.iterdir()) == ["faults.json", "faults.md"]


def test_an_unknown_kind_is_wrong_use(companion: "Run") -> None:
    ran = companion("bench", "faults", "--only", "gremlin")
    assert ran.status == 2
    assert "there are motor_weak" in ran.err
