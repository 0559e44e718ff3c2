import json
import re
from pathlib import Path

import pytest
from command_line import Run

from companion.bundled import config_directory


@pytest.mark.parametrize(
    ("vehicle", "autopilot", "parameter"),
    [("bebop2", "PX4", "COM_OBL_RC_ACT"), ("arducopter_sitl", "ArduPilot", "GUID_TIMEOUT")],
)
def test_a_vehicle_that_can_fly_is_ready(
    companion: Run, tmp_path: Path, vehicle: str, autopilot: str, parameter: str
) -> None:
    result = tmp_path / "doctor.json"
    ran = companion("doctor", "--connect", f"sitl://{vehicle}", "--seconds", 3, "--json", result)
    assert ran.status == 0, ran.err
    assert f"connected to system 1, {autopilot}" in ran.out
    assert "ready: nothing stops a flight" in ran.out
    told = json.loads(result.read_text())
    assert told["ready"]
    assert told["observed"]["identity"]["autopilot"] == autopilot
    assert told["observed"]["streams"]["LOCAL_POSITION_NED"]["rate_hz"] > 50.0
    assert told["observed"]["losses"]["1.1"]["share"] == 0.0
    assert told["observed"]["round_trips"]["median_s"] > 0.0
    assert parameter in {finding["topic"] for finding in told["findings"]}


def test_an_unsafe_parameter_stops_a_flight(companion: Run, tmp_path: Path) -> None:
    text = (config_directory() / "vehicles" / "arducopter_sitl.yaml").read_text()
    unsafe = tmp_path / "unsafe.yaml"
    unsafe.write_text(re.sub(r"GUID_TIMEOUT: .*", "GUID_TIMEOUT: 5.0", text))
    result = tmp_path / "doctor.json"
    ran = companion("doctor", "--connect", f"sitl://{unsafe}", "--seconds", 2, "--json", result)
    assert ran.status == 1
    assert "not ready: 1 of these stop a flight" in ran.out
    (finding,) = (each for each in json.loads(result.read_text())["findings"] if each["severity"] == "stops")
    assert finding["topic"] == "GUID_TIMEOUT"
    assert "set GUID_TIMEOUT 3" in finding["advice"]


def test_a_vehicle_that_is_not_there_has_likely_causes(companion: Run) -> None:
    ran = companion("doctor", "--connect", "sitl://bebop2", "--system-id", 7, "--patience", 3)
    assert ran.status == 1
    assert "no vehicle heard within 3 s" in ran.err
    assert "autopilots heard: systems 1; asked for 7" in ran.err


def test_a_wrong_connection_string_is_wrong_use(companion: Run) -> None:
    ran = companion("doctor", "--connect", "udp:14540")
    assert ran.status == 2
    assert "udpin://" in ran.err
