"""Commands: COMMAND_LONG, COMMAND_INT and SET_MODE, answered as PX4 answers them."""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np
from pymavlink.dialects.v20 import common as mavlink

from sitl.firmware.interface import Mode, Result
from sitl.mavlink import modes
from sitl.mavlink.frames import Message
from sitl.mavlink.geodesy import HOME, Geodetic, ned_from_geodetic
from sitl.mavlink.session import Session
from sitl.mavlink.telemetry import WRITERS

_FORCE = 21196
_IGNORED_COORDINATE = 2**31 - 1
_ABOVE_SEA = (mavlink.MAV_FRAME_GLOBAL, mavlink.MAV_FRAME_GLOBAL_INT)
_ABOVE_HOME = (mavlink.MAV_FRAME_GLOBAL_RELATIVE_ALT, mavlink.MAV_FRAME_GLOBAL_RELATIVE_ALT_INT)

_HARMLESS = (mavlink.MAV_CMD_REQUEST_MESSAGE, mavlink.MAV_CMD_REQUEST_PROTOCOL_VERSION)

_RESULTS = {
    Result.ACCEPTED: mavlink.MAV_RESULT_ACCEPTED,
    Result.TEMPORARILY_REJECTED: mavlink.MAV_RESULT_TEMPORARILY_REJECTED,
    Result.DENIED: mavlink.MAV_RESULT_DENIED,
    Result.FAILED: mavlink.MAV_RESULT_FAILED,
}


@dataclass(frozen=True, slots=True)
class Command:
    """A command, whichever message it came in.

    Attributes:
        id: MAV_CMD.
        params: the first four parameters.
        place: parameters 5 to 7; a coordinate that is NaN is left as it is.
        frame: MAV_FRAME of `place`.
    """

    id: int
    params: tuple[float, float, float, float]
    place: Geodetic
    frame: int = mavlink.MAV_FRAME_GLOBAL


def on_command_long(session: Session, message: mavlink.MAVLink_command_long_message) -> None:
    """Answer a COMMAND_LONG."""
    params = (message.param1, message.param2, message.param3, message.param4)
    place = Geodetic(message.param5, message.param6, message.param7)
    if _is_for(session, message):
        _answer(session, message, Command(message.command, params, place))


def on_command_int(session: Session, message: mavlink.MAVLink_command_int_message) -> None:
    """Answer a COMMAND_INT."""
    params = (message.param1, message.param2, message.param3, message.param4)
    if message.x == message.y == _IGNORED_COORDINATE:
        place = Geodetic(math.nan, math.nan, message.z)
    else:
        place = Geodetic(message.x * 1e-7, message.y * 1e-7, message.z)
    if _is_for(session, message):
        _answer(session, message, Command(message.command, params, place, message.frame))


def on_set_mode(session: Session, message: mavlink.MAVLink_set_mode_message) -> None:
    """Answer a SET_MODE as the command that has replaced it."""
    main, sub = message.custom_mode >> 16 & 0xFF, message.custom_mode >> 24
    command = Command(
        mavlink.MAV_CMD_DO_SET_MODE, (message.base_mode, main, sub, 0.0), Geodetic(0.0, 0.0, 0.0)
    )
    if message.target_system == session.system_id:
        _answer(session, message, command)


def _is_for(
    session: Session, message: mavlink.MAVLink_command_long_message | mavlink.MAVLink_command_int_message
) -> bool:
    """Commands to every system are taken only where they do no more than ask."""
    if message.target_system == 0 and message.command not in _HARMLESS:
        return False
    return session.accepts(message.target_system, message.target_component)


def _answer(session: Session, message: Message, command: Command) -> None:
    execute = _COMMANDS.get(command.id)
    session.send(
        mavlink.MAVLink_command_ack_message(
            command=command.id,
            result=execute(session, command) if execute else mavlink.MAV_RESULT_UNSUPPORTED,
            target_system=message.get_srcSystem(),
            target_component=message.get_srcComponent(),
        )
    )


def _whole(value: float) -> int:
    """A parameter that means a whole number; -1, which no command knows, when it is none."""
    return round(value) if math.isfinite(value) else -1


def _arm_or_disarm(session: Session, command: Command) -> int:
    force = _whole(command.params[1]) == _FORCE
    match _whole(command.params[0]):
        case 1:
            return _RESULTS[session.firmware.arm(force=force)]
        case 0:
            return _RESULTS[session.firmware.disarm(force=force)]
        case _:
            return mavlink.MAV_RESULT_DENIED


def _set_mode(session: Session, command: Command) -> int:
    base, main, sub = (_whole(value) for value in command.params[:3])
    mode = modes.mode_from_px4(main, sub) if base & mavlink.MAV_MODE_FLAG_CUSTOM_MODE_ENABLED else None
    if mode is None:
        return mavlink.MAV_RESULT_TEMPORARILY_REJECTED
    return _RESULTS[session.firmware.set_mode(mode)]


def _enter(mode: Mode) -> Callable[[Session, Command], int]:
    return lambda session, command: _RESULTS[session.firmware.set_mode(mode)]


def _local(command: Command) -> tuple[float, float, float] | None:
    """The command's place in NED (m from home); None when it is none on earth, or its frame not geodetic."""
    place = command.place
    if abs(place.latitude_deg) > 90.0 or abs(place.longitude_deg) > 180.0 or abs(place.altitude_m) > 1e5:
        return None
    north, east, down = ned_from_geodetic(place)
    if command.frame in _ABOVE_SEA:
        return north, east, down
    if command.frame in _ABOVE_HOME:
        return north, east, down - HOME.altitude_m
    return None


def _take_off(session: Session, command: Command) -> int:
    """To an altitude, or to MIS_TAKEOFF_ALT; the place on the map is left to the vehicle, as in PX4."""
    local = _local(command)
    if local is None:
        return mavlink.MAV_RESULT_DENIED
    if math.isnan(command.place.altitude_m):
        return _RESULTS[session.firmware.takeoff()]
    climb_m = float(session.firmware.estimate.position[2]) - local[2]
    return _RESULTS[session.firmware.takeoff(climb_m)]


def _reposition(session: Session, command: Command) -> int:
    local = _local(command)
    if local is None:
        return mavlink.MAV_RESULT_DENIED
    if _whole(command.params[1]) != mavlink.MAV_DO_REPOSITION_FLAGS_CHANGE_MODE:
        return mavlink.MAV_RESULT_UNSUPPORTED  # PX4 takes no other flags, and none without this one
    yaw = command.params[3]
    return _RESULTS[session.firmware.reposition(np.array(local), yaw if math.isfinite(yaw) else math.nan)]


def _send_once(session: Session, message_id: int) -> int:
    write = WRITERS.get(message_id)
    if write is None:
        return mavlink.MAV_RESULT_DENIED
    session.send(write(session.report()))
    return mavlink.MAV_RESULT_ACCEPTED


def _request_message(session: Session, command: Command) -> int:
    return _send_once(session, _whole(command.params[0]))


def _request(message_id: int) -> Callable[[Session, Command], int]:
    return lambda session, command: _send_once(session, message_id)


def _set_message_interval(session: Session, command: Command) -> int:
    message_id, interval_us = _whole(command.params[0]), command.params[1]
    known = message_id in WRITERS and message_id != mavlink.MAVLINK_MSG_ID_HEARTBEAT
    elsewhere = any(_whole(value) > 0 for value in (*command.params[2:], command.place.altitude_m))
    if not known or elsewhere or not math.isfinite(interval_us) or interval_us > _IGNORED_COORDINATE:
        return mavlink.MAV_RESULT_FAILED
    session.streams.set_interval(message_id, round(interval_us), round(session.time_s * 1e6))
    return mavlink.MAV_RESULT_ACCEPTED


def _get_message_interval(session: Session, command: Command) -> int:
    """MESSAGE_INTERVAL has -1 for a stream that is off and 0 for one that does not exist."""
    message_id = _whole(command.params[0])
    if not 0 <= message_id <= 0xFFFF:
        return mavlink.MAV_RESULT_DENIED
    interval_us = session.streams.interval_us(message_id) or (-1 if message_id in WRITERS else 0)
    session.send(mavlink.MAVLink_message_interval_message(message_id, interval_us))
    return mavlink.MAV_RESULT_ACCEPTED


def _deny(session: Session, command: Command) -> int:
    return mavlink.MAV_RESULT_DENIED


_COMMANDS: Mapping[int, Callable[[Session, Command], int]] = {
    mavlink.MAV_CMD_NAV_RETURN_TO_LAUNCH: _enter(Mode.RTL),
    mavlink.MAV_CMD_NAV_LAND: _enter(Mode.LAND),
    mavlink.MAV_CMD_NAV_TAKEOFF: _take_off,
    mavlink.MAV_CMD_DO_SET_MODE: _set_mode,
    mavlink.MAV_CMD_DO_REPOSITION: _reposition,
    mavlink.MAV_CMD_COMPONENT_ARM_DISARM: _arm_or_disarm,
    mavlink.MAV_CMD_GET_HOME_POSITION: _request(mavlink.MAVLINK_MSG_ID_HOME_POSITION),
    mavlink.MAV_CMD_INJECT_FAILURE: _deny,
    mavlink.MAV_CMD_GET_MESSAGE_INTERVAL: _get_message_interval,
    mavlink.MAV_CMD_SET_MESSAGE_INTERVAL: _set_message_interval,
    mavlink.MAV_CMD_REQUEST_MESSAGE: _request_message,
    mavlink.MAV_CMD_REQUEST_PROTOCOL_VERSION: _deny,
    mavlink.MAV_CMD_REQUEST_AUTOPILOT_CAPABILITIES: _request(mavlink.MAVLINK_MSG_ID_AUTOPILOT_VERSION),
}
"""What each command does, by MAV_CMD; the result is a MAV_RESULT."""
