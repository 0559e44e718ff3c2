"""Commands: COMMAND_LONG and COMMAND_INT, their answers, and what every autopilot makes of them."""

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from pymavlink.dialects.v20 import common as mavlink

from sitl.firmware.interface import Mode, Result
from sitl.geodesy import HOME, Geodetic, ned_from_geodetic
from sitl.mavlink.flavour import Execute
from sitl.mavlink.frames import Message
from sitl.mavlink.session import Session
from sitl.mavlink.telemetry import written

_FORCE = 21196
_IGNORED_COORDINATE = 2**31 - 1
_ABOVE_SEA = (None, mavlink.MAV_FRAME_GLOBAL, mavlink.MAV_FRAME_GLOBAL_INT)
_ABOVE_HOME = (mavlink.MAV_FRAME_GLOBAL_RELATIVE_ALT, mavlink.MAV_FRAME_GLOBAL_RELATIVE_ALT_INT)


@dataclass(frozen=True, slots=True)
class Command:
    """A command, whichever message it came in.

    Attributes:
        id: MAV_CMD.
        params: the first four parameters.
        place: parameters 5 to 7; a coordinate that is NaN is left as it is.
        frame: MAV_FRAME of `place`; None for the one that the autopilot takes for this command.
    """

    id: int
    params: tuple[float, float, float, float]
    place: Geodetic
    frame: int | None = None


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


def _is_for(
    session: Session, message: mavlink.MAVLink_command_long_message | mavlink.MAVLink_command_int_message
) -> bool:
    to_all = message.target_system == 0
    if to_all and message.command not in session.flavour.commands_to_all:
        return False
    return session.accepts(message.target_system, message.target_component)


def _answer(session: Session, message: Message, command: Command) -> None:
    execute = session.flavour.commands.get(command.id)
    result = execute(session, command) if execute else mavlink.MAV_RESULT_UNSUPPORTED
    acknowledge(session, message, command.id, result)


def acknowledge(session: Session, message: Message, command_id: int, result: int) -> None:
    """Tell the sender of `message` the MAV_RESULT of a command."""
    session.send(
        mavlink.MAVLink_command_ack_message(
            command=command_id,
            result=result,
            target_system=message.get_srcSystem(),
            target_component=message.get_srcComponent(),
        )
    )


def whole(value: float) -> int:
    """A parameter that means a whole number; -1, which no command knows, when it is none."""
    return round(value) if math.isfinite(value) else -1


def _arm_or_disarm(session: Session, command: Command) -> int:
    force = whole(command.params[1]) == _FORCE
    match whole(command.params[0]):
        case 1:
            return session.result(session.firmware.arm(force=force))
        case 0:
            return session.result(session.firmware.disarm(force=force))
        case _:
            return mavlink.MAV_RESULT_DENIED


def set_mode(session: Session, base_mode: int, custom_mode: int) -> int:
    """Go to a mode by its number; the result is a MAV_RESULT."""
    custom = base_mode >= 0 and base_mode & mavlink.MAV_MODE_FLAG_CUSTOM_MODE_ENABLED
    mode = session.flavour.modes.get(custom_mode) if custom else None
    if mode is None:
        return session.result(Result.TEMPORARILY_REJECTED)
    return session.result(session.firmware.set_mode(mode))


def _enter(mode: Mode) -> Execute:
    return lambda session, command: session.result(session.firmware.set_mode(mode))


def local_place(session: Session, command: Command) -> tuple[float, float, float] | None:
    """The command's place in NED (m from home); None when it is none on earth, or its frame not geodetic."""
    place = command.place
    if abs(place.latitude_deg) > 90.0 or abs(place.longitude_deg) > 180.0 or abs(place.altitude_m) > 1e5:
        return None
    north, east, down = ned_from_geodetic(place, session.flavour.earth_radius_m)
    if command.frame in _ABOVE_SEA:
        return north, east, down
    if command.frame in _ABOVE_HOME:
        return north, east, down - HOME.altitude_m + float(session.firmware.plans.home[2])
    return None


def _reposition(session: Session, command: Command) -> int:
    place = local_place(session, command)
    if place is None:
        return mavlink.MAV_RESULT_DENIED
    if whole(command.params[1]) != mavlink.MAV_DO_REPOSITION_FLAGS_CHANGE_MODE:
        return mavlink.MAV_RESULT_UNSUPPORTED  # PX4 takes no other flags, and none without this one
    yaw = command.params[3]
    yaw = yaw if math.isfinite(yaw) else math.nan
    return session.result(session.firmware.reposition(np.array(place), yaw))


def _send_once(session: Session, message_id: int) -> int:
    message = written(message_id, session.report())
    if message is None:
        return mavlink.MAV_RESULT_DENIED
    session.send(message)
    return mavlink.MAV_RESULT_ACCEPTED


def _request_message(session: Session, command: Command) -> int:
    return _send_once(session, whole(command.params[0]))


def _request(message_id: int) -> Execute:
    return lambda session, command: _send_once(session, message_id)


def set_message_interval(session: Session, command: Command) -> int:
    """Send a message at another rate on this link; the result is a MAV_RESULT."""
    message_id, interval_us = whole(command.params[0]), command.params[1]
    elsewhere = any(whole(value) > 0 for value in (*command.params[2:], command.place.altitude_m))
    known = message_id in session.flavour.writers
    if not known or elsewhere or not math.isfinite(interval_us) or interval_us > _IGNORED_COORDINATE:
        return mavlink.MAV_RESULT_FAILED
    session.streams.set_interval(message_id, round(interval_us), round(session.time_s * 1e6))
    return mavlink.MAV_RESULT_ACCEPTED


def _get_message_interval(session: Session, command: Command) -> int:
    """MESSAGE_INTERVAL has -1 for a stream that is off and 0 for one that does not exist."""
    message_id = whole(command.params[0])
    if not 0 <= message_id <= 0xFFFF:
        return mavlink.MAV_RESULT_DENIED
    interval_us = session.streams.interval_us(message_id) or (
        -1 if message_id in session.flavour.writers else 0
    )
    session.send(mavlink.MAVLink_message_interval_message(message_id, interval_us))
    return mavlink.MAV_RESULT_ACCEPTED


def _deny(session: Session, command: Command) -> int:
    return mavlink.MAV_RESULT_DENIED


COMMANDS: Mapping[int, Execute] = {
    mavlink.MAV_CMD_NAV_RETURN_TO_LAUNCH: _enter(Mode.RTL),
    mavlink.MAV_CMD_NAV_LAND: _enter(Mode.LAND),
    mavlink.MAV_CMD_DO_REPOSITION: _reposition,
    mavlink.MAV_CMD_COMPONENT_ARM_DISARM: _arm_or_disarm,
    mavlink.MAV_CMD_GET_HOME_POSITION: _request(mavlink.MAVLINK_MSG_ID_HOME_POSITION),
    mavlink.MAV_CMD_GET_MESSAGE_INTERVAL: _get_message_interval,
    mavlink.MAV_CMD_SET_MESSAGE_INTERVAL: set_message_interval,
    mavlink.MAV_CMD_REQUEST_MESSAGE: _request_message,
    mavlink.MAV_CMD_REQUEST_PROTOCOL_VERSION: _deny,
    mavlink.MAV_CMD_REQUEST_AUTOPILOT_CAPABILITIES: _request(mavlink.MAVLINK_MSG_ID_AUTOPILOT_VERSION),
}
"""What every autopilot does for a command, by MAV_CMD."""
