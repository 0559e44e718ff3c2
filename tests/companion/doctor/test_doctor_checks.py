import math
from dataclasses import replace
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st
from observations import ARDUPILOT, PX4, found

from companion.autopilot import Identity
from companion.doctor import Observation, Severity, judge
from companion.doctor.checks import RULES
from companion.doctor.observation import Loss, Peer, RoundTrips, Stream
from companion.link.dialect import mavlink
from companion.link.estimator import Estimator

STOPS, WARNS, FINE = Severity.STOPS, Severity.WARNS, Severity.FINE
OTHER_VEHICLE = Peer(2, 1, mavlink.MAV_TYPE_QUADROTOR, mavlink.MAV_AUTOPILOT_PX4)
GROUND_STATION = Peer(255, 190, mavlink.MAV_TYPE_GCS, mavlink.MAV_AUTOPILOT_INVALID)
OTHER_COMPANION = Peer(1, 191, mavlink.MAV_TYPE_ONBOARD_CONTROLLER, mavlink.MAV_AUTOPILOT_INVALID)
SLOW = {"LOCAL_POSITION_NED": Stream(4.0, 0.01, 0.3), "ATTITUDE": Stream(20.0, 0.01, 0.1)}
GAPPY = {**PX4.streams, "ATTITUDE": Stream(98.0, 0.05, 0.8)}


@pytest.mark.parametrize("seen", [PX4, ARDUPILOT])
def test_nothing_is_wrong_with_a_healthy_vehicle(seen: Observation) -> None:
    assert {finding.severity for finding in judge(seen)} == {FINE}


@pytest.mark.parametrize(
    ("topic", "severity", "changes"),
    [
        ("vehicle", STOPS, {"identity": Identity("autopilot 8", "1.0.0")}),
        ("vehicle", STOPS, {"is_multirotor": False}),
        ("vehicle", STOPS, {"identity": Identity("PX4", "1.16.1", takes_setpoints=False)}),
        ("vehicle", WARNS, {"identity": Identity("PX4")}),
        ("mode", WARNS, {"mode": "OFFBOARD", "armed": True}),
        ("mode", FINE, {"mode": "OFFBOARD"}),
        ("mode", FINE, {"mode": "AUTO.MISSION", "armed": True}),
        ("estimator", STOPS, {"estimator": Estimator(missing=("horizontal position",))}),
        ("estimator", STOPS, {"estimator": None, "has_position": False}),
        ("estimator", FINE, {"estimator": None}),
        ("estimator", WARNS, {"estimator": Estimator(gps_glitch=True)}),
        ("estimator", WARNS, {"estimator": Estimator(worst_ratio=0.9)}),
        ("GPS", WARNS, {"gps_fix": 1}),
        ("home", WARNS, {"has_home": False}),
        ("arming", STOPS, {"ready_to_arm": False, "complaints": ("PreArm: Compass not healthy",)}),
        ("arming", WARNS, {"ready_to_arm": None}),
        ("arming", FINE, {"ready_to_arm": False, "armed": True}),
        ("said", WARNS, {"complaints": ("Battery low",)}),
        ("battery", STOPS, {"battery": 0.05}),
        ("battery", WARNS, {"battery": 0.2}),
        ("battery", WARNS, {"battery": None}),
        ("LOCAL_POSITION_NED", STOPS, {"streams": SLOW}),
        ("ATTITUDE", WARNS, {"streams": SLOW}),
        ("ATTITUDE", WARNS, {"streams": GAPPY}),
        ("ATTITUDE", STOPS, {"streams": {}}),
        ("loss", WARNS, {"losses": {(1, 1): Loss(frames=950, lost=50)}}),
        ("loss", STOPS, {"losses": {(1, 1): Loss(frames=500, lost=500)}}),
        ("noise", WARNS, {"bad_checksums": 500}),
        ("latency", WARNS, {"round_trips": None}),
        ("latency", STOPS, {"round_trips": RoundTrips(9, 9, 0.8, 0.9, 0.0, 0.0)}),
        ("latency", WARNS, {"round_trips": RoundTrips(9, 9, 0.1, 0.3, 0.0, 0.0)}),
        ("clock", WARNS, {"round_trips": RoundTrips(9, 9, 0.001, 0.002, 0.0, 20_000.0)}),
        ("vehicles", WARNS, {"peers": (OTHER_VEHICLE, replace(OTHER_VEHICLE, system_id=1))}),
        ("companions", WARNS, {"peers": (OTHER_COMPANION,)}),
        ("signing", WARNS, {"vehicle_signs": True}),
        ("signing", FINE, {"vehicle_signs": True, "we_sign": True}),
        ("parameters", WARNS, {"parameters": {}}),
    ],
)
def test_what_is_seen_is_judged(topic: str, severity: Severity, changes: dict[str, Any]) -> None:
    finding = found(PX4, topic, **changes)
    assert finding.severity is severity
    assert bool(finding.advice) == (severity is not FINE)


@pytest.mark.parametrize(
    ("seen", "name", "value", "severity"),
    [
        (PX4, "COM_OF_LOSS_T", 10.0, STOPS),
        (PX4, "COM_OF_LOSS_T", 3.0, WARNS),
        (PX4, "COM_OF_LOSS_T", 0.1, WARNS),
        *((PX4, "COM_OBL_RC_ACT", value, STOPS) for value in (-1, 2, 6, 7)),
        *((PX4, "COM_OBL_RC_ACT", value, FINE) for value in (0, 1, 3, 4, 5)),
        (PX4, "NAV_RCL_ACT", 6, WARNS),
        (PX4, "NAV_RCL_ACT", 2, FINE),
        (PX4, "NAV_DLL_ACT", 0, FINE),
        (PX4, "NAV_DLL_ACT", 2, WARNS),
        (PX4, "NAV_DLL_ACT", 5, WARNS),
        (PX4, "GF_ACTION", 4, WARNS),
        (PX4, "GF_ACTION", 2, FINE),
        (PX4, "MPC_XY_VEL_MAX", 1.0, WARNS),
        (PX4, "MPC_TILTMAX_AIR", 45.0, FINE),
        (PX4, "SDLOG_MODE", -1, WARNS),
        (ARDUPILOT, "GUID_TIMEOUT", 3.5, STOPS),
        (ARDUPILOT, "GUID_TIMEOUT", 0.1, WARNS),
        (ARDUPILOT, "GUID_OPTIONS", 16, STOPS),
        (ARDUPILOT, "GUID_OPTIONS", 64, FINE),
        (ARDUPILOT, "ARMING_CHECK", 0, WARNS),
        (ARDUPILOT, "ARMING_SKIPCHK", -1, WARNS),
        (ARDUPILOT, "ARMING_SKIPCHK", 0, FINE),
        (ARDUPILOT, "SYSID_MYGCS", 255, FINE),
        (ARDUPILOT, "MAV_GCS_SYSID", 1, FINE),
        (ARDUPILOT, "FS_OPTIONS", 4, FINE),
        (ARDUPILOT, "WPNAV_SPEED", 100.0, WARNS),
        (ARDUPILOT, "WP_SPD", 10.0, FINE),
        (ARDUPILOT, "SERIAL2_PROTOCOL", 1, WARNS),
    ],
)
def test_parameters_are_judged(seen: Observation, name: str, value: float, severity: Severity) -> None:
    finding = found(seen, name, parameters={name: value})
    assert finding.severity is severity
    assert (name in finding.advice) == (severity is not FINE)


@pytest.mark.parametrize(
    ("value", "severity"), [(0, WARNS), (1, STOPS), (2, STOPS), (3, FINE), (4, FINE), (5, FINE)]
)
def test_without_a_remote_control_nobody_takes_over(value: int, severity: Severity) -> None:
    finding = found(PX4, "COM_OBL_RC_ACT", parameters={"COM_OBL_RC_ACT": value}, has_remote_control=False)
    assert finding.severity is severity


@pytest.mark.parametrize(
    ("version", "value", "severity", "set_to"),
    [("1.13.3", 1, WARNS, "COM_RCL_EXCEPT 5"), ("1.13.3", 4, FINE, ""), ("1.16.1", 0, FINE, "")],
)
def test_before_1_14_a_remote_control_is_missed_in_offboard(
    version: str, value: int, severity: Severity, set_to: str
) -> None:
    finding = found(
        PX4,
        "COM_RCL_EXCEPT",
        identity=Identity("PX4", version),
        parameters={"COM_RCL_EXCEPT": value},
        has_remote_control=False,
    )
    assert finding.severity is severity
    assert set_to in finding.advice


def test_sticks_from_a_remote_control_that_is_off_are_told() -> None:
    changes = {"parameters": {"COM_RC_IN_MODE": 0}, "has_remote_control": False}
    assert found(PX4, "COM_RC_IN_MODE", **changes).severity is WARNS
    assert found(PX4, "COM_RC_IN_MODE", parameters={"COM_RC_IN_MODE": 0}).severity is FINE


def test_a_ground_station_that_is_heard_is_not_missed() -> None:
    finding = found(PX4, "NAV_DLL_ACT", parameters={"NAV_DLL_ACT": 2}, peers=(GROUND_STATION,))
    assert finding.severity is FINE


@pytest.mark.parametrize("name", ["SYSID_ENFORCE", "MAV_OPTIONS"])
def test_a_vehicle_that_obeys_only_its_ground_station_obeys_its_own_components_too(name: str) -> None:
    findings = judge(replace(ARDUPILOT, parameters={name: 1, "SYSID_MYGCS": 255}))
    assert STOPS not in {finding.severity for finding in findings}


def test_a_ground_station_that_heartbeats_carelessly_is_no_second_vehicle() -> None:
    peers = (replace(OTHER_VEHICLE, system_id=1), replace(GROUND_STATION, autopilot=0))
    assert "vehicles" not in {finding.topic for finding in judge(replace(PX4, peers=peers))}


def test_a_vehicle_that_was_named_is_not_to_be_named() -> None:
    peers = (OTHER_VEHICLE, replace(OTHER_VEHICLE, system_id=1))
    findings = judge(replace(PX4, peers=peers, chosen=True))
    assert "vehicles" not in {finding.topic for finding in findings}


def test_the_vehicles_own_words_are_the_reason() -> None:
    finding = found(ARDUPILOT, "arming", ready_to_arm=False, complaints=("PreArm: need 3D Fix",))
    assert "PreArm: need 3D Fix" in finding.seen


@given(
    value=st.floats(allow_infinity=False, allow_nan=False, width=32), whole=st.integers(-(2**31), 2**31 - 1)
)
def test_no_value_confuses_a_rule(value: float, whole: int) -> None:
    for seen in (PX4, ARDUPILOT):
        rules = RULES[seen.identity.autopilot]
        for each in (value, whole):
            findings = judge(replace(seen, parameters=dict.fromkeys(rules, each)))
            assert len(findings) > len(rules)


def test_a_value_that_is_no_number_confuses_no_rule() -> None:
    findings = judge(replace(PX4, parameters=dict.fromkeys(RULES["PX4"], math.nan)))
    assert sum("no value" in finding.seen for finding in findings) == len(RULES["PX4"])
