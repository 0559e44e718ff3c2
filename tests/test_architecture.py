"""The rules on who may import whom, read from the sources."""

import ast
from collections.abc import Iterator
from pathlib import Path

import pytest

ROOT = Path(__file__).parent.parent
SOURCES = [path.relative_to(ROOT) for room in ("companion", "sitl") for path in (ROOT / room).rglob("*.py")]
MAY_IMPORT_SITL = ("companion/link/simulated.py", "companion/cli/", "companion/experiments/")
MAY_READ_A_CLOCK = ("companion/clock.py",)
HEAVY = {"torch": "companion/learning/descent.py", "matplotlib": "companion/experiments/", "numba": "sitl/"}


def _imports(path: Path) -> Iterator[str]:
    for node in ast.walk(ast.parse((ROOT / path).read_text())):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom) and node.module:
            yield node.module


@pytest.mark.parametrize("path", SOURCES, ids=str)
def test_imports_keep_to_the_rules(path: Path) -> None:
    packages = {name.partition(".")[0] for name in _imports(path)}
    if path.parts[0] == "sitl":
        assert "companion" not in packages
    elif not str(path).startswith(MAY_IMPORT_SITL):
        assert "sitl" not in packages
    for package, where in HEAVY.items():
        assert package not in packages or str(path).startswith(where)
    assert "pickle" not in packages


@pytest.mark.parametrize("room", ["learning", "trajectory", "state"])
def test_a_room_of_arrays_knows_no_vehicle(room: str) -> None:
    for path in SOURCES:
        if path.parts[:2] == ("companion", room):
            rooms = {name.split(".")[1] for name in _imports(path) if name.startswith("companion.")}
            assert not rooms & {"link", "autopilot", "flight", "cli", "experiments"}, path


@pytest.mark.parametrize("path", SOURCES, ids=str)
def test_only_the_clock_reads_a_clock(path: Path) -> None:
    if not str(path).startswith(MAY_READ_A_CLOCK):
        assert not {"time", "datetime"} & set(_imports(path))
