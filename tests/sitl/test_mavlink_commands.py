import math
from typing import Any

import pytest
from mavlink_fakes import PEER_COMPONENT, PEER_SYSTEM, FakeFirmware, answers, command_long, fake_vehicle
from pymavlink.dialects.v20 import common as mavlink

from sitl.firmware.interface import Mode, Result
from sitl.geodesy import HOME, geodetic_from_ned

NAN = math.nan
ACCEPTED, REJECTED, DENIED, UNSUPPORTED, FAILED = 0, 1, 2, 3, 4


def commanded(command: Any, answer: Result = Result.ACCEPTED) -> tuple[int, FakeFirmware, list[Any]]:
    """The result of a command, the firmware that executed it, and what came before the acknowledgement."""
    vehicle, firmware = fake_vehicle()
    firmware.answer = answer
    *before, acknowledgement = answers(vehicle, command)
    assert acknowledgement.get_type() == "COMMAND_ACK"
    assert acknowledgement.command == command.command
    assert acknowledgement.target_system == PEER_SYSTEM
    assert acknowledgement.target_component == PEER_COMPONENT
    return acknowledgement.result, firmware, before


def command_int(
    command: int, frame: int, p1: float, p2: float, p3: float, p4: float, *, x: int, y: int, z: float
) -> Any:
    return mavlink.MAVLink_command_int_message(1, 1, frame, command, 0, 0, p1, p2, p3, p4, x, y, z)


@pytest.mark.parametrize(
    ("params", "call"),
    [
        ((1.0,), ("arm", False)),
        ((1.0, 21196.0), ("arm", True)),
        ((0.0,), ("disarm", False)),
        ((0.0, 21196.0), ("disarm", True)),
        ((1.0, NAN), ("arm", False)),
    ],
)
def test_arm_and_disarm(params: tuple[float, ...], call: tuple[Any, ...]) -> None:
    result, firmware, _ = commanded(command_long(mavlink.MAV_CMD_COMPONENT_ARM_DISARM, *params))
    assert (result, firmware.calls) == (ACCEPTED, [call])


@pytest.mark.parametrize("value", [2.0, -1.0, NAN, math.inf])
def test_arming_by_half_is_denied(value: float) -> None:
    result, firmware, _ = commanded(command_long(mavlink.MAV_CMD_COMPONENT_ARM_DISARM, value))
    assert (result, firmware.calls) == (DENIED, [])


@pytest.mark.parametrize(
    ("answer", "expected"),
    [
        (Result.TEMPORARILY_REJECTED, REJECTED),
        (Result.DENIED, DENIED),
        (Result.FAILED, FAILED),
    ],
)
def test_a_refusal_of_the_firmware_reaches_the_peer(answer: Result, expected: int) -> None:
    assert commanded(command_long(mavlink.MAV_CMD_COMPONENT_ARM_DISARM, 1.0), answer)[0] == expected


@pytest.mark.parametrize(
    ("command", "mode"),
    [(mavlink.MAV_CMD_NAV_LAND, Mode.LAND), (mavlink.MAV_CMD_NAV_RETURN_TO_LAUNCH, Mode.RTL)],
)
def test_land_and_return(command: int, mode: Mode) -> None:
    _, firmware, _ = commanded(command_long(command, 0.0, 0.0, 0.0, NAN))
    assert firmware.calls == [("set_mode", mode)]


def test_takeoff_without_an_altitude_is_the_vehicles_own() -> None:
    _, firmware, _ = commanded(command_long(mavlink.MAV_CMD_NAV_TAKEOFF, 0.0, 0.0, 0.0, NAN, NAN, NAN, NAN))
    assert firmware.calls == [("takeoff", None)]


def test_takeoff_altitude_is_above_the_sea() -> None:
    _, firmware, _ = commanded(command_long(mavlink.MAV_CMD_NAV_TAKEOFF, 0, 0, 0, NAN, NAN, NAN, 495.0))
    assert firmware.calls == [("takeoff", pytest.approx(4.0))]  # home is at 488 m, the vehicle 3 m above it


def test_takeoff_altitude_may_be_above_home() -> None:
    frame = mavlink.MAV_FRAME_GLOBAL_RELATIVE_ALT_INT
    command = command_int(mavlink.MAV_CMD_NAV_TAKEOFF, frame, 0, 0, 0, NAN, x=0, y=0, z=10.0)
    assert commanded(command)[1].calls == [("takeoff", pytest.approx(7.0))]


@pytest.mark.parametrize(
    ("main", "sub", "mode"), [(3, 0, Mode.POSCTL), (4, 3, Mode.HOLD), (6, 0, Mode.OFFBOARD)]
)
def test_modes_are_set_by_command_and_by_message(main: int, sub: int, mode: Mode) -> None:
    result, firmware, _ = commanded(command_long(mavlink.MAV_CMD_DO_SET_MODE, 1.0, main, sub))
    assert (result, firmware.calls) == (ACCEPTED, [("set_mode", mode)])

    vehicle, firmware = fake_vehicle()
    (acknowledgement,) = answers(vehicle, mavlink.MAVLink_set_mode_message(1, 1, main << 16 | sub << 24))
    assert (acknowledgement.command, firmware.calls) == (mavlink.MAV_CMD_DO_SET_MODE, [("set_mode", mode)])


@pytest.mark.parametrize("params", [(1.0, 9.0, 0.0), (1.0, 4.0, 9.0), (0.0, 6.0, 0.0), (NAN, NAN, NAN)])
def test_a_mode_that_there_is_not_is_rejected(params: tuple[float, ...]) -> None:
    result, firmware, _ = commanded(command_long(mavlink.MAV_CMD_DO_SET_MODE, *params))
    assert (result, firmware.calls) == (REJECTED, [])


@pytest.mark.parametrize(
    ("frame", "altitude"),
    [(mavlink.MAV_FRAME_GLOBAL_INT, HOME.altitude_m + 6.0), (mavlink.MAV_FRAME_GLOBAL_RELATIVE_ALT_INT, 6.0)],
)
def test_reposition_goes_to_the_place_on_the_map(frame: int, altitude: float) -> None:
    place = geodetic_from_ned(30.0, -40.0, 0.0)
    x, y = round(place.latitude_deg * 1e7), round(place.longitude_deg * 1e7)
    command = command_int(mavlink.MAV_CMD_DO_REPOSITION, frame, -1.0, 1.0, 0.0, 1.5, x=x, y=y, z=altitude)
    (call,) = commanded(command)[1].calls
    assert call[0] == "reposition"
    assert call[1:] == pytest.approx((30.0, -40.0, -6.0, 1.5), abs=0.02)


def test_reposition_keeps_what_is_not_given() -> None:
    unset = 2**31 - 1
    frame = mavlink.MAV_FRAME_GLOBAL_INT
    command = command_int(mavlink.MAV_CMD_DO_REPOSITION, frame, -1.0, 1.0, 0.0, NAN, x=unset, y=unset, z=NAN)
    (call,) = commanded(command)[1].calls
    assert all(math.isnan(value) for value in call[1:])


def test_reposition_in_a_local_frame_is_denied() -> None:
    frame = mavlink.MAV_FRAME_LOCAL_NED
    command = command_int(mavlink.MAV_CMD_DO_REPOSITION, frame, -1.0, 1.0, 0.0, NAN, x=0, y=0, z=0.0)
    assert commanded(command)[0] == DENIED


def test_reposition_without_leave_to_change_the_mode_is_unsupported() -> None:
    assert commanded(command_long(mavlink.MAV_CMD_DO_REPOSITION, -1.0, 0.0))[0] == UNSUPPORTED


@pytest.mark.parametrize(
    ("command", "params", "name"),
    [
        (mavlink.MAV_CMD_REQUEST_MESSAGE, (148.0,), "AUTOPILOT_VERSION"),
        (mavlink.MAV_CMD_REQUEST_MESSAGE, (242.0,), "HOME_POSITION"),
        (mavlink.MAV_CMD_REQUEST_AUTOPILOT_CAPABILITIES, (1.0,), "AUTOPILOT_VERSION"),
        (mavlink.MAV_CMD_GET_HOME_POSITION, (), "HOME_POSITION"),
    ],
)
def test_a_message_is_sent_once_on_request(command: int, params: tuple[float, ...], name: str) -> None:
    result, _, before = commanded(command_long(command, *params))
    assert (result, [message.get_type() for message in before]) == (ACCEPTED, [name])


@pytest.mark.parametrize("message_id", [300.0, 65000.0, -5.0, NAN])
def test_a_message_that_there_is_not_is_denied(message_id: float) -> None:
    assert commanded(command_long(mavlink.MAV_CMD_REQUEST_MESSAGE, message_id))[0] == DENIED


@pytest.mark.parametrize(
    "params",
    [
        (0.0, 1e5),  # heartbeat
        (65000.0, 1e5),
        (NAN, 1e5),
        (30.0, NAN),
        (30.0, math.inf),
        (30.0, 1e4, 1.0),
        (30.0, 1e4, 0.0, 0.0, 0.0, 0.0, 1.0),
    ],
)
def test_nonsense_intervals_fail(params: tuple[float, ...]) -> None:
    assert commanded(command_long(mavlink.MAV_CMD_SET_MESSAGE_INTERVAL, *params))[0] == FAILED


@pytest.mark.parametrize(("interval_us", "answer"), [(20_000.0, 20_000), (-1.0, -1), (0.0, 10_000)])
def test_an_interval_can_be_set_and_asked_for(interval_us: float, answer: int) -> None:
    vehicle, _ = fake_vehicle()
    set_it = command_long(mavlink.MAV_CMD_SET_MESSAGE_INTERVAL, 30.0, interval_us)
    ask_for_it = command_long(mavlink.MAV_CMD_GET_MESSAGE_INTERVAL, 30.0)
    (interval,) = [m for m in answers(vehicle, set_it, ask_for_it) if m.get_type() == "MESSAGE_INTERVAL"]
    assert (interval.message_id, interval.interval_us) == (30, answer)


def test_the_interval_of_a_message_that_there_is_not_is_zero() -> None:
    _, _, (interval,) = commanded(command_long(mavlink.MAV_CMD_GET_MESSAGE_INTERVAL, 65000.0))
    assert interval.interval_us == 0


@pytest.mark.parametrize("command", [31010, 301, 16])
def test_other_commands_are_unsupported(command: int) -> None:
    assert commanded(command_long(command))[0] == UNSUPPORTED


@pytest.mark.parametrize(("system", "component"), [(2, 1), (1, 191), (0, 0)])
def test_commands_to_others_are_not_answered(system: int, component: int) -> None:
    vehicle, firmware = fake_vehicle()
    command = command_long(mavlink.MAV_CMD_COMPONENT_ARM_DISARM, 1.0, system=system, component=component)
    assert (answers(vehicle, command), firmware.calls) == ([], [])


def test_a_request_for_a_message_may_go_to_everyone() -> None:
    vehicle, _ = fake_vehicle()
    request = command_long(mavlink.MAV_CMD_REQUEST_MESSAGE, 148.0, system=0, component=0)
    assert len(answers(vehicle, request)) == 2
