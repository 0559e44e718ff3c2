"""What is in a flight's recording besides the flight: how it was asked for, and the vehicle's parameters."""

from pathlib import Path

import pytest
from command_line import Run

from companion.autopilot.flown_parameters import FLOWN_BY
from companion.cli import recorded
from companion.link.dialect import mavlink
from companion.recording.mcap_reader import Item, Message, Metadata, read_items
from companion.recording.topics import EVENTS, PARAMETERS, Level


@pytest.fixture
def line(tmp_path: Path) -> Path:
    line = tmp_path / "line.csv"
    line.write_text("t,n,e,d\n0,0,0,-2\n1,0.2,0,-2\n2,0.5,0,-2\n3,0.6,0,-2\n")
    return line


def fly(companion: Run, line: Path, vehicle: str, *options: object) -> list[Item]:
    record = line.with_name("flight.mcap")
    ran = companion("fly", line, "--connect", vehicle, "--record", record, *options)
    assert ran.status == 0, ran.err
    return list(read_items(record))


@pytest.mark.parametrize(
    ("vehicle", "autopilot", "telling"),
    [
        (
            "bebop2",
            "PX4",
            {"MPC_XY_P": 0.95, "MPC_Z_VEL_MAX_DN": 1.5, "COM_OF_LOSS_T": 1.0, "GF_ACTION": 2.0},
        ),
        ("arducopter_sitl", "ArduPilot", {"PSC_POSXY_P": 1.0, "ANGLE_MAX": 3000.0, "FENCE_RADIUS": 300.0}),
    ],
)
def test_a_recording_has_the_parameters_that_the_vehicle_flies_by(
    companion: Run, line: Path, vehicle: str, autopilot: str, telling: dict[str, float]
) -> None:
    items = fly(companion, line, f"sitl://{vehicle}")
    said = [item for item in items if isinstance(item, Message)]
    told = {each.fields["name"]: each.fields["value"] for each in said if each.topic == PARAMETERS}
    assert {name: told[name] for name in telling} == pytest.approx(telling)
    named = [each.fields["message"] for each in said if each.fields.get("name") == "parameters"]
    untold = set(named[0].partition(": ")[2].split(", ")) if named else set()
    assert set(FLOWN_BY[autopilot]) - set(told) == untold


def test_parameters_that_are_not_told_hold_a_flight_up_for_two_seconds_at_most(
    companion: Run, line: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    unknown = [f"UNKNOWN_{number}" for number in range(60)]
    monkeypatch.setattr(recorded, "FLOWN_BY", {"PX4": ("MPC_XY_P", *unknown)})
    said = [item for item in fly(companion, line, "sitl://bebop2") if isinstance(item, Message)]
    (untold,) = (each for each in said if each.fields.get("name") == "parameters")
    assert untold.fields["message"].endswith(": " + ", ".join(unknown))
    assert untold.time_s < said[0].time_s + 2.5


def test_a_recording_has_the_whole_configuration(companion: Run, line: Path) -> None:
    guard = line.with_name("guard.yaml")
    guard.write_text("tracking_error_m: 1.25")
    items = fly(companion, line, "sitl://bebop2", "--guard", guard, "--yaw", "path", "--land")
    (told,) = (item.values for item in items if isinstance(item, Metadata) and item.name == "configuration")
    assert told["command"].startswith(f"companion fly {line} --connect sitl://bebop2 --record")
    assert told["guard"]["tracking_error_m"] == 1.25
    assert told["guard"]["watchdogs"]["state_age_s"]["action"] == "hold"
    assert told["limits"]["down_m_s"] == pytest.approx(1.2)
    assert (told["yaw"], told["after"], told["resume"]) == ("path", "land", False)


@pytest.mark.parametrize(
    ("severity", "level"),
    [
        (mavlink.MAV_SEVERITY_EMERGENCY, Level.ERROR),
        (mavlink.MAV_SEVERITY_ERROR, Level.ERROR),
        (mavlink.MAV_SEVERITY_WARNING, Level.WARNING),
        (mavlink.MAV_SEVERITY_NOTICE, Level.INFO),
        (mavlink.MAV_SEVERITY_DEBUG, Level.INFO),
    ],
)
def test_what_the_vehicle_says_is_as_grave_in_a_viewer(severity: int, level: Level) -> None:
    assert recorded.level_of(severity) is level


def test_what_ended_a_flight_is_an_error_in_a_viewer(companion: Run, line: Path) -> None:
    record = line.with_name("flight.mcap")
    ran = companion("fly", line, "--connect", "sitl://bebop2?fault=gps_lost:at_s=10", "--record", record)
    assert ran.status == 1
    said = [item.fields for item in read_items(record) if isinstance(item, Message) and item.topic == EVENTS]
    assert [each["message"][:10] for each in said if each["level"] == Level.ERROR] == ["no GPS fix"]
