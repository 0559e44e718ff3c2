"""What ArduPilot's face has of its own; what it shares with PX4's is tested there."""

import math
from typing import Any

import numpy as np
import pytest
from mavlink_fakes import ARDUCOPTER, FakeFirmware, answers, command_long, encode, fake_vehicle, parse
from pymavlink.dialects.v20 import common as mavlink

from sitl.firmware.interface import Landed, Mode, Result
from sitl.mavlink import TELEMETRY

ACCEPTED, DENIED, FAILED = 0, 2, 4
POSITION_VELOCITY = 0b1101_1100_0000


def commanded(command: Any, answer: Result = Result.ACCEPTED) -> tuple[int, FakeFirmware]:
    vehicle, firmware = fake_vehicle(vehicle=ARDUCOPTER)
    firmware.answer = answer
    (acknowledgement,) = answers(vehicle, command)
    return acknowledgement.result, firmware


def heartbeat(**state: Any) -> Any:
    vehicle, firmware = fake_vehicle(vehicle=ARDUCOPTER)
    for name, value in state.items():
        setattr(firmware, name, value)
    (beat,) = (message for message in parse(vehicle.advance(0.01)) if message.get_type() == "HEARTBEAT")
    return beat


@pytest.mark.parametrize(
    ("mode", "number", "name"),
    [
        (Mode.STABILIZE, 0, "STABILIZE"),
        (Mode.OFFBOARD, 4, "GUIDED"),
        (Mode.HOLD, 5, "LOITER"),
        (Mode.RTL, 6, "RTL"),
        (Mode.LAND, 9, "LAND"),
        (Mode.BRAKE, 17, "BRAKE"),
    ],
)
def test_modes_have_copters_numbers_and_names(mode: Mode, number: int, name: str) -> None:
    vehicle, firmware = fake_vehicle(vehicle=ARDUCOPTER)
    firmware.mode = mode
    assert vehicle.mode_name == name
    beat = heartbeat(mode=mode)
    assert (beat.autopilot, beat.custom_mode) == (mavlink.MAV_AUTOPILOT_ARDUPILOTMEGA, number)
    result, firmware = commanded(command_long(mavlink.MAV_CMD_DO_SET_MODE, 1.0, number))
    assert (result, firmware.calls) == (ACCEPTED, [("set_mode", mode)])


@pytest.mark.parametrize(
    ("state", "flags", "status"),
    [
        ({"mode": Mode.STABILIZE}, 81, mavlink.MAV_STATE_STANDBY),
        ({"mode": Mode.OFFBOARD}, 89, mavlink.MAV_STATE_STANDBY),
        ({"mode": Mode.OFFBOARD, "armed": True}, 217, mavlink.MAV_STATE_STANDBY),
        ({"mode": Mode.OFFBOARD, "armed": True, "landed": Landed.IN_AIR}, 217, mavlink.MAV_STATE_ACTIVE),
        ({"mode": Mode.LAND, "armed": True, "failsafe": True}, 217, mavlink.MAV_STATE_CRITICAL),
    ],
)
def test_heartbeats_are_those_of_a_recorded_flight(state: dict[str, Any], flags: int, status: int) -> None:
    beat = heartbeat(**state)
    assert (beat.base_mode, beat.system_status) == (flags, status)


def test_only_heartbeats_and_time_come_unasked() -> None:
    vehicle, _ = fake_vehicle(vehicle=ARDUCOPTER)
    assert vehicle.links == (TELEMETRY,)
    assert {message.get_type() for message in parse(vehicle.advance(20.0))} == {"HEARTBEAT", "TIMESYNC"}


def test_set_mode_is_answered_by_its_own_message_id() -> None:
    vehicle, firmware = fake_vehicle(vehicle=ARDUCOPTER)
    (acknowledgement,) = answers(vehicle, mavlink.MAVLink_set_mode_message(1, 1, 4))
    assert (acknowledgement.command, acknowledgement.result) == (mavlink.MAVLINK_MSG_ID_SET_MODE, ACCEPTED)
    assert firmware.calls == [("set_mode", Mode.OFFBOARD)]


@pytest.mark.parametrize("params", [(1.0, 2.0), (1.0, 99.0), (0.0, 4.0), (math.nan, 4.0), (1.0, math.nan)])
def test_a_mode_that_there_is_not_fails(params: tuple[float, float]) -> None:
    result, firmware = commanded(command_long(mavlink.MAV_CMD_DO_SET_MODE, *params))
    assert (result, firmware.calls) == (FAILED, [])


def test_what_is_refused_for_now_fails() -> None:
    arm = command_long(mavlink.MAV_CMD_COMPONENT_ARM_DISARM, 1.0)
    assert commanded(arm, Result.TEMPORARILY_REJECTED)[0] == FAILED


def test_takeoff_altitude_is_above_home() -> None:
    result, firmware = commanded(command_long(mavlink.MAV_CMD_NAV_TAKEOFF, 0, 0, 0, 0, 0, 0, 5.0))
    assert (result, firmware.calls) == (ACCEPTED, [("takeoff", 5.0)])


def test_takeoff_without_an_altitude_fails() -> None:
    nowhere = command_long(mavlink.MAV_CMD_NAV_TAKEOFF, 0, 0, 0, 0, 0, 0, math.nan)
    assert commanded(nowhere)[0] == FAILED


@pytest.mark.parametrize(
    ("frame", "expected"),
    [(mavlink.MAV_FRAME_GLOBAL_RELATIVE_ALT, ACCEPTED), (mavlink.MAV_FRAME_GLOBAL, DENIED)],
)
def test_takeoff_in_a_frame_that_is_not_above_home_is_denied(frame: int, expected: int) -> None:
    command = mavlink.MAVLink_command_int_message(
        1, 1, frame, mavlink.MAV_CMD_NAV_TAKEOFF, 0, 0, 0, 0, 0, 0, 0, 0, 5.0
    )
    assert commanded(command)[0] == expected


def test_it_says_what_it_is() -> None:
    vehicle, _ = fake_vehicle(vehicle=ARDUCOPTER)
    version, _ = answers(vehicle, command_long(mavlink.MAV_CMD_REQUEST_MESSAGE, 148.0))
    assert version.flight_sw_version >> 24 == 4
    assert not version.capabilities & mavlink.MAV_PROTOCOL_CAPABILITY_PARAM_ENCODE_BYTEWISE
    assert version.capabilities & mavlink.MAV_PROTOCOL_CAPABILITY_SET_POSITION_TARGET_LOCAL_NED


def test_home_is_told_by_its_place_alone() -> None:
    vehicle, firmware = fake_vehicle(vehicle=ARDUCOPTER)
    first, _ = answers(vehicle, command_long(mavlink.MAV_CMD_REQUEST_MESSAGE, 242.0))
    firmware.plans.home = np.array([10.0, 5.0, -1.0])
    home, _ = answers(vehicle, command_long(mavlink.MAV_CMD_REQUEST_MESSAGE, 242.0))
    assert (home.x, home.y, home.z) == (0.0, 0.0, 0.0)
    assert home.latitude - first.latitude == pytest.approx(898, abs=1)


@pytest.mark.parametrize("stream", [mavlink.MAV_DATA_STREAM_POSITION, mavlink.MAV_DATA_STREAM_ALL])
def test_streams_are_started_and_stopped_as_a_whole(stream: int) -> None:
    vehicle, _ = fake_vehicle(vehicle=ARDUCOPTER)
    ask = mavlink.MAVLink_request_data_stream_message
    vehicle.receive(encode(ask(1, 1, stream, 10, 1)))
    told = [message.get_type() for message in parse(vehicle.advance(0.95))]
    assert told.count("LOCAL_POSITION_NED") == told.count("GLOBAL_POSITION_INT") == 10
    vehicle.receive(encode(ask(1, 1, stream, 0, 0)))
    assert "LOCAL_POSITION_NED" not in {message.get_type() for message in parse(vehicle.advance(2.0))}


def guided_setpoint(mask: int, frame: int = mavlink.MAV_FRAME_LOCAL_NED) -> Any:
    values = [float(value) for value in range(1, 12)]
    return mavlink.MAVLink_set_position_target_local_ned_message(0, 1, 1, frame, mask, *values)


@pytest.mark.parametrize("mode", [mode for mode in Mode if mode is not Mode.OFFBOARD])
def test_setpoints_outside_guided_are_dropped_without_a_word(mode: Mode) -> None:
    vehicle, firmware = fake_vehicle(vehicle=ARDUCOPTER)
    firmware.mode = mode
    assert answers(vehicle, guided_setpoint(POSITION_VELOCITY)) == []
    assert firmware.setpoints == []


def test_setpoints_in_guided_reach_the_firmware() -> None:
    vehicle, firmware = fake_vehicle(vehicle=ARDUCOPTER)
    firmware.mode = Mode.OFFBOARD
    answers(vehicle, guided_setpoint(POSITION_VELOCITY))
    (setpoint,) = firmware.setpoints
    np.testing.assert_array_equal(setpoint.position, [1.0, 2.0, 3.0])
    np.testing.assert_array_equal(setpoint.velocity, [4.0, 5.0, 6.0])
    assert np.isnan(setpoint.acceleration).all()


@pytest.mark.parametrize("command", [400, 22, 21, 20, 176, 192, 511, 510, 512, 519, 520, 410])
@pytest.mark.parametrize("value", [math.nan, math.inf, -math.inf, 3.4e38, -1.0])
def test_commands_bear_any_number(command: int, value: float) -> None:
    vehicle, _ = fake_vehicle(vehicle=ARDUCOPTER)
    vehicle.receive(encode(command_long(command, *[value] * 7)))
    assert any(message.get_type() == "COMMAND_ACK" for message in parse(vehicle.advance(0.02)))


def test_a_command_to_every_system_is_taken() -> None:
    command = mavlink.MAVLink_command_long_message(
        0, 0, mavlink.MAV_CMD_NAV_TAKEOFF, 0, 0, 0, 0, 0, 0, 0, 4.0
    )
    result, firmware = commanded(command)
    assert (result, firmware.calls) == (ACCEPTED, [("takeoff", 4.0)])
