import json
from pathlib import Path

import pytest
from command_line import Run

from companion.mission import Mission, Place, Plan, read_plan, write_plan

HOME = Place(47.397742, 8.545594, 488.0)


@pytest.fixture
def plan(tmp_path: Path) -> Path:
    file = tmp_path / "there.plan"
    write_plan(Mission().takeoff(3).go(3, 0, 3).land(3, 0).plan(HOME), file)
    return file


def test_an_upload_is_verified(companion: Run, plan: Path, tmp_path: Path) -> None:
    result = tmp_path / "result.json"
    ran = companion("mission", "upload", plan, "--connect", "sitl://bebop2", "--json", result)
    assert ran.status == 0, ran.err
    assert "uploaded to system 1 and verified: 3 items" in ran.out
    told = json.loads(result.read_text())
    assert (told["verified"], told["items"], told["system_id"]) == (True, 3, 1)


def test_a_download_writes_a_file_that_can_be_read(companion: Run, tmp_path: Path) -> None:
    file = tmp_path / "kept.plan"
    ran = companion("mission", "download", file, "--connect", "sitl://arducopter_sitl")
    assert ran.status == 0, ran.err
    assert read_plan(file) == Plan(home=read_plan(file).home, firmware=3)


def test_a_mission_is_seen_through(companion: Run, plan: Path, tmp_path: Path) -> None:
    result = tmp_path / "result.json"
    ran = companion("mission", "start", plan, "--connect", "sitl://bebop2", "--wait", "--json", result)
    assert ran.status == 0, ran.err
    told = [
        ran.out.index(text) for text in ("reached 1 of 3: NAV_TAKEOFF", "reached 2 of 3", "mission is done")
    ]
    assert told == sorted(told)
    assert json.loads(result.read_text())["done"]


def test_without_wait_the_vehicle_is_left_to_its_mission(companion: Run, plan: Path) -> None:
    ran = companion("mission", "start", plan, "--connect", "sitl://bebop2")
    assert ran.status == 0, ran.err
    assert "the vehicle flies its mission" in ran.out


def test_there_must_be_a_mission_to_start(companion: Run) -> None:
    ran = companion("mission", "start", "--connect", "sitl://bebop2")
    assert ran.status == 2
    assert "there is no mission to fly" in ran.err


def test_clearing_is_told(companion: Run) -> None:
    ran = companion("mission", "clear", "--connect", "sitl://bebop2")
    assert ran.status == 0, ran.err
    assert "system 1 has no mission" in ran.out


def test_a_plan_is_validated_without_a_vehicle(companion: Run, plan: Path, tmp_path: Path) -> None:
    result = tmp_path / "result.json"
    ran = companion("mission", "validate", plan, "--json", result)
    assert (ran.status, ran.err) == (0, "")
    assert json.loads(result.read_text())["faults"] == []
    ran = companion("mission", "validate", plan, "--max-distance", "2")
    assert ran.status == 2
    assert "item 1: NAV_WAYPOINT is 3 m from takeoff" in ran.err


def test_a_plan_is_validated_by_a_vehicle(companion: Run, tmp_path: Path) -> None:
    file = tmp_path / "far.plan"
    write_plan(Mission().takeoff(3).go(3, 0, 3).plan(Place(48.0, 9.0, 400.0)), file)
    assert companion("mission", "validate", file).status == 0
    ran = companion("mission", "validate", file, "--connect", "sitl://bebop2")
    assert ran.status == 2
    assert "m from takeoff, more than 500 m" in ran.err


@pytest.mark.parametrize("command", [["validate"], ["upload", "--connect", "sitl://bebop2"]])
def test_a_wrong_file_is_named(companion: Run, tmp_path: Path, command: list[str]) -> None:
    file = tmp_path / "wrong.plan"
    file.write_text('{"fileType": "Plan", "version": 7}')
    ran = companion("mission", command[0], file, *command[1:])
    assert ran.status == 2
    assert ran.err.startswith(f"error: {file}: version: ")
    assert "Traceback" not in ran.err
