import io
import json
from pathlib import Path

import pytest
from command_line import Run

BOTH = pytest.mark.parametrize(
    ("url", "stack", "name", "kind"),
    [
        ("sitl://bebop2", "PX4 Pro", "MPC_XY_VEL_MAX", 9),
        ("sitl://arducopter_sitl", "ArduPilot", "WPNAV_SPEED", 9),
    ],
)


@BOTH
def test_parameters_are_pulled_compared_and_pushed(
    companion: Run, tmp_path: Path, url: str, stack: str, name: str, kind: int
) -> None:
    file, result = tmp_path / "mine.params", tmp_path / "result.json"
    ran = companion("params", "pull", file, "--connect", url)
    assert ran.status == 0, ran.err
    lines = file.read_text().splitlines()
    assert lines[0] == "# Onboard parameters for Vehicle 1"
    assert f"# Stack: {stack}" in lines
    (line,) = (each for each in lines if each.split("\t")[2:3] == [name])
    assert line.split("\t")[4] == str(kind)

    ran = companion("params", "diff", file, url)
    assert ran.status == 0, ran.err
    assert "no differences" in ran.out

    value = float(line.split("\t")[3])
    file.write_text(f"{name} {value + 1}\nNOT_THERE 5\n")
    ran = companion("params", "diff", url, file, "--json", result)
    assert ran.status == 0, ran.err
    assert "1 parameters differ" in ran.out
    assert "only in B, 1: NOT_THERE" in ran.out
    told = {each["name"]: each for each in json.loads(result.read_text())}
    assert told[name] == {"name": name, "before": value, "after": value + 1}

    ran = companion("params", "push", file, "--connect", url, "--yes")
    assert ran.status == 2
    assert "line 2: the vehicle has no parameter NOT_THERE" in ran.err

    file.write_text(f"{name},{value + 1}\n")
    ran = companion("params", "push", file, "--connect", url, "--dry-run", "--json", result)
    assert ran.status == 0, ran.err
    told_change = {"name": name, "before": value, "after": value + 1, "refused": None}
    assert json.loads(result.read_text()) == {"dry_run": True, "changes": [told_change]}

    ran = companion("params", "push", file, "--connect", url, "--yes", "--json", result)
    assert ran.status == 0, ran.err
    assert "1 of 1 set and verified" in ran.out
    assert json.loads(result.read_text()) == {"dry_run": False, "changes": [told_change]}


def test_nothing_is_set_where_nobody_agrees(
    companion: Run, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("sys.stdin", io.StringIO())
    file = tmp_path / "mine.params"
    file.write_text("MPC_XY_VEL_MAX 10\n")
    ran = companion("params", "push", file, "--connect", "sitl://bebop2")
    assert ran.status == 2
    assert "--yes" in ran.err


def test_help_shows_the_three(companion: Run) -> None:
    ran = companion("params", "--help")
    assert ran.status == 0
    for name in ("pull", "push", "diff"):
        assert name in ran.out


def test_two_files_are_compared_without_a_vehicle(companion: Run, tmp_path: Path) -> None:
    one, other = tmp_path / "one.parm", tmp_path / "other.params"
    one.write_text("A 1\nB 2.5\n")
    other.write_text("1\t1\tA\t1\t6\n1\t1\tB\t2.75\t9\n1\t154\tC\t1\t6\n")
    ran = companion("params", "diff", one, other)
    assert ran.status == 0
    assert "1 parameters of other components left out" in ran.out
    assert "1 parameters differ" in ran.out
    assert "2.75" in ran.out
