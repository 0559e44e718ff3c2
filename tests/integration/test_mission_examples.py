"""The scripts in scripts/examples, each flown to its end."""

import runpy
import sys
from pathlib import Path

import pytest

EXAMPLES = Path(__file__).parents[2] / "scripts" / "examples"
ENDINGS = {
    "survey_grid.py": "10/10 NAV_WAYPOINT",
    "inspection_orbit.py": "back home",
    "upload_plan.py": "the mission is done",
    "patrol.py": "battery low: returning\nback home",
}


@pytest.mark.parametrize("vehicle", ["bebop2", "arducopter_sitl"])
@pytest.mark.parametrize("name", sorted(path.name for path in EXAMPLES.glob("*.py")))
def test_an_example_flies_to_its_end(
    name: str, vehicle: str, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    early = ["--return-at", "0.99"] if name == "patrol.py" else []
    monkeypatch.setattr(sys, "argv", [name, *early, "--connect", f"sitl://{vehicle}"])
    runpy.run_path(str(EXAMPLES / name), run_name="__main__")
    assert ENDINGS[name] in capsys.readouterr().out
