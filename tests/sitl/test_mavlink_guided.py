"""What moves a vehicle beside local setpoints: places on the map, headings, items that are no mission."""

import math
from typing import Any

import numpy as np
import pytest
from mavlink_fakes import ARDUCOPTER, BEBOP2, FakeFirmware, answers, command_long, fake_vehicle
from pymavlink.dialects.v20 import common as mavlink

from sitl.firmware.interface import Mode
from sitl.geodesy import ARDUPILOT_EARTH_M, HOME, PX4_EARTH_M, geodetic_from_ned, ned_from_geodetic
from sitl.vehicle import Vehicle

ACCEPTED, DENIED, FAILED = mavlink.MAV_RESULT_ACCEPTED, mavlink.MAV_RESULT_DENIED, mavlink.MAV_RESULT_FAILED
PLACE = geodetic_from_ned(30.0, -40.0, 0.0)
LAT, LON = round(PLACE.latitude_deg * 1e7), round(PLACE.longitude_deg * 1e7)


def asked(
    message: Any, mode: Mode = Mode.OFFBOARD, vehicle: Vehicle = ARDUCOPTER
) -> tuple[Any, FakeFirmware]:
    flying, firmware = fake_vehicle(vehicle=vehicle)
    firmware.mode = mode
    replies = answers(flying, message)
    return replies[-1] if replies else None, firmware


def global_setpoint(frame: int, altitude: float) -> Any:
    mask, system, component = 0b1101_1111_1000, 1, 1
    return mavlink.MAVLink_set_position_target_global_int_message(
        0, system, component, frame, mask, LAT, LON, altitude, *[0.0] * 8
    )


@pytest.mark.parametrize(
    ("vehicle", "earth_m"),
    [(BEBOP2, PX4_EARTH_M), (ARDUCOPTER, ARDUPILOT_EARTH_M)],
    ids=["px4", "ardupilot"],
)
@pytest.mark.parametrize(
    ("frame", "altitude"),
    [
        (mavlink.MAV_FRAME_GLOBAL_INT, HOME.altitude_m + 5.0),
        (mavlink.MAV_FRAME_GLOBAL_RELATIVE_ALT_INT, 5.0),
        (mavlink.MAV_FRAME_GLOBAL_TERRAIN_ALT_INT, 5.0),
    ],
)
def test_a_setpoint_on_the_map_is_flown_as_a_local_one(
    vehicle: Vehicle, earth_m: float, frame: int, altitude: float
) -> None:
    _, firmware = asked(global_setpoint(frame, altitude), vehicle=vehicle)
    north, east, _ = ned_from_geodetic(PLACE, earth_m)
    np.testing.assert_allclose(firmware.setpoints[0].position, [north, east, -5.0], atol=0.02)


def test_px4_says_why_it_takes_no_setpoint_in_another_frame() -> None:
    text, firmware = asked(global_setpoint(mavlink.MAV_FRAME_MISSION, 5.0), vehicle=BEBOP2)
    assert "unsupported" in text.text
    assert firmware.setpoints == []


@pytest.mark.parametrize(
    ("flags", "mode", "expected"),
    [(1.0, Mode.HOLD, ACCEPTED), (0.0, Mode.HOLD, DENIED), (0.0, Mode.OFFBOARD, ACCEPTED)],
)
def test_ardupilot_goes_to_a_place_in_guided_only(flags: float, mode: Mode, expected: int) -> None:
    frame = mavlink.MAV_FRAME_GLOBAL_RELATIVE_ALT_INT
    command = mavlink.MAVLink_command_int_message(
        1, 1, frame, mavlink.MAV_CMD_DO_REPOSITION, 0, 0, -1.0, flags, 0.0, math.nan, LAT, LON, 5.0
    )
    acknowledgement, firmware = asked(command, mode)
    assert acknowledgement.result == expected
    assert [call[0] for call in firmware.calls] == ["reposition"] * (expected == ACCEPTED)


@pytest.mark.parametrize(
    ("params", "yaw_deg"),
    [((90.0, 0.0, 1.0, 0.0), 90.0), ((30.0, 0.0, -1.0, 1.0), -30.0), ((30.0, 0.0, 1.0, 1.0), 30.0)],
)
def test_ardupilot_turns_to_a_heading_or_by_an_angle(params: tuple[float, ...], yaw_deg: float) -> None:
    acknowledgement, firmware = asked(command_long(mavlink.MAV_CMD_CONDITION_YAW, *params))
    assert acknowledgement.result == ACCEPTED
    assert firmware.calls == [("turn", pytest.approx(math.radians(yaw_deg)))]


@pytest.mark.parametrize("params", [(361.0, 0.0, 1.0, 0.0), (math.nan,), (10.0, 0.0, 1.0, 2.0)])
def test_a_turn_that_makes_no_sense_fails(params: tuple[float, ...]) -> None:
    acknowledgement, firmware = asked(command_long(mavlink.MAV_CMD_CONDITION_YAW, *params))
    assert (acknowledgement.result, firmware.calls) == (FAILED, [])


def test_loiter_as_mavproxy_asks_for_it() -> None:
    acknowledgement, firmware = asked(command_long(mavlink.MAV_CMD_NAV_LOITER_UNLIM))
    assert (acknowledgement.result, firmware.calls) == (ACCEPTED, [("set_mode", Mode.HOLD)])


@pytest.mark.parametrize(("mode", "expected"), [(Mode.OFFBOARD, 0), (Mode.HOLD, mavlink.MAV_MISSION_ERROR)])
@pytest.mark.parametrize("whole", [True, False])
def test_a_guided_item_is_flown_to(mode: Mode, expected: int, whole: bool) -> None:
    head: Any = (
        1,
        1,
        0,
        mavlink.MAV_FRAME_GLOBAL_RELATIVE_ALT,
        mavlink.MAV_CMD_NAV_WAYPOINT,
        2,
        0,
        *[0.0] * 4,
    )
    item = (
        mavlink.MAVLink_mission_item_int_message(*(*head, LAT, LON, 5.0))
        if whole
        else mavlink.MAVLink_mission_item_message(*(*head, LAT * 1e-7, LON * 1e-7, 5.0))
    )
    acknowledgement, firmware = asked(item, mode)
    assert acknowledgement.type == expected
    expected_calls = [("reposition", *(pytest.approx(v, abs=0.5) for v in (30.0, -40.0, -5.0)))]
    assert [call[:4] for call in firmware.calls] == (expected_calls if mode is Mode.OFFBOARD else [])


def test_px4_acknowledges_offboard_twice() -> None:
    vehicle, _ = fake_vehicle()
    replies = answers(vehicle, command_long(mavlink.MAV_CMD_DO_SET_MODE, 1.0, 6.0))
    assert [(reply.command, reply.result) for reply in replies] == [(176, ACCEPTED)] * 2
