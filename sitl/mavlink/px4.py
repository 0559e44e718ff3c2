"""PX4 as it speaks MAVLink."""

import math

from pymavlink.dialects.v20 import common as mavlink

from sitl.firmware.interface import Autopilot, Mode, Result, Severity
from sitl.geodesy import PX4_EARTH_M
from sitl.mavlink import mission_telemetry, px4_parameters, system_commands, targets, wellbeing
from sitl.mavlink.commands import (
    COMMANDS,
    Command,
    acknowledge,
    local_place,
    on_command_long,
    set_message_interval,
    set_mode,
    whole,
)
from sitl.mavlink.flavour import Flavour
from sitl.mavlink.global_setpoints import as_local
from sitl.mavlink.links import CURRENT_MODE, GROUND_STATION, OFFBOARD
from sitl.mavlink.mission_commands import PX4_COMMANDS
from sitl.mavlink.mission_wires import PX4_MISSIONS
from sitl.mavlink.session import Session
from sitl.mavlink.setpoints import SetpointRefusedError, read_setpoint
from sitl.mavlink.telemetry import WRITERS

_VERSION = 1 << 24 | 16 << 16 | 0 << 8 | mavlink.FIRMWARE_VERSION_TYPE_OFFICIAL
_CAPABILITIES = (
    mavlink.MAV_PROTOCOL_CAPABILITY_MISSION_FLOAT
    | mavlink.MAV_PROTOCOL_CAPABILITY_PARAM_FLOAT
    | mavlink.MAV_PROTOCOL_CAPABILITY_MISSION_INT
    | mavlink.MAV_PROTOCOL_CAPABILITY_COMMAND_INT
    | mavlink.MAV_PROTOCOL_CAPABILITY_PARAM_ENCODE_BYTEWISE
    | mavlink.MAV_PROTOCOL_CAPABILITY_SET_POSITION_TARGET_LOCAL_NED
    | mavlink.MAV_PROTOCOL_CAPABILITY_SET_POSITION_TARGET_GLOBAL_INT
    | mavlink.MAV_PROTOCOL_CAPABILITY_FLIGHT_TERMINATION
    | mavlink.MAV_PROTOCOL_CAPABILITY_MAVLINK2
    | mavlink.MAV_PROTOCOL_CAPABILITY_MISSION_FENCE
    | mavlink.MAV_PROTOCOL_CAPABILITY_MISSION_RALLY
)
_RESULTS = {
    Result.ACCEPTED: mavlink.MAV_RESULT_ACCEPTED,
    Result.TEMPORARILY_REJECTED: mavlink.MAV_RESULT_TEMPORARILY_REJECTED,
    Result.DENIED: mavlink.MAV_RESULT_DENIED,
    Result.FAILED: mavlink.MAV_RESULT_FAILED,
}


def _custom_mode(main: int, sub: int) -> int:
    """A main and a sub mode in one number (px4_custom_mode.h)."""
    return main << 16 | sub << 24


_OFFBOARD_MAIN_MODE = 6
_CUSTOM_MODES = {
    Mode.ALTCTL: _custom_mode(2, 0),
    Mode.STABILIZE: _custom_mode(7, 0),
    Mode.POSCTL: _custom_mode(3, 0),
    Mode.TAKEOFF: _custom_mode(4, 2),
    Mode.HOLD: _custom_mode(4, 3),
    Mode.MISSION: _custom_mode(4, 4),
    Mode.RTL: _custom_mode(4, 5),
    Mode.LAND: _custom_mode(4, 6),
    Mode.OFFBOARD: _custom_mode(_OFFBOARD_MAIN_MODE, 0),
}
_PILOTED_MODES = (Mode.POSCTL, Mode.ALTCTL, Mode.STABILIZE)
_PILOTED = (
    mavlink.MAV_MODE_FLAG_CUSTOM_MODE_ENABLED
    | mavlink.MAV_MODE_FLAG_STABILIZE_ENABLED
    | mavlink.MAV_MODE_FLAG_MANUAL_INPUT_ENABLED
)
_AUTOMATIC = (
    mavlink.MAV_MODE_FLAG_CUSTOM_MODE_ENABLED
    | mavlink.MAV_MODE_FLAG_STABILIZE_ENABLED
    | mavlink.MAV_MODE_FLAG_GUIDED_ENABLED
    | mavlink.MAV_MODE_FLAG_AUTO_ENABLED
)


def _base_mode(mode: Mode, armed: bool) -> int:
    flags = _PILOTED if mode in _PILOTED_MODES else _AUTOMATIC
    return flags | mavlink.MAV_MODE_FLAG_SAFETY_ARMED if armed else flags


def _system_status(firmware: Autopilot) -> int:
    if not firmware.armed:
        return mavlink.MAV_STATE_STANDBY
    return mavlink.MAV_STATE_CRITICAL if firmware.failsafe else mavlink.MAV_STATE_ACTIVE


def _set_mode(session: Session, command: Command) -> int:
    base, main, sub = (whole(value) for value in command.params[:3])
    one_byte_each = 0 <= main <= 0xFF and 0 <= sub <= 0xFF
    return set_mode(session, base, _custom_mode(main, sub) if one_byte_each else -1)


def _set_message_interval(session: Session, command: Command) -> int:
    """PX4 sends HEARTBEAT at its own rate; changes of mode show in CURRENT_MODE."""
    if whole(command.params[0]) == mavlink.MAVLINK_MSG_ID_HEARTBEAT:
        return mavlink.MAV_RESULT_FAILED
    return set_message_interval(session, command)


def _on_set_mode(session: Session, message: mavlink.MAVLink_set_mode_message) -> None:
    """Answer a SET_MODE as the command that has replaced it."""
    if message.target_system == session.system_id:
        result = set_mode(session, message.base_mode, message.custom_mode & 0xFFFF0000)
        acknowledge(session, message, mavlink.MAV_CMD_DO_SET_MODE, result)


def _take_off(session: Session, command: Command) -> int:
    """To an altitude, or to MIS_TAKEOFF_ALT; the place on the map is left to the vehicle, as in PX4."""
    place = local_place(session, command)
    if place is None:
        return mavlink.MAV_RESULT_DENIED
    if math.isnan(command.place.altitude_m):
        return session.result(session.firmware.takeoff())
    climb_m = float(session.firmware.estimate.position[2]) - place[2]
    return session.result(session.firmware.takeoff(climb_m))


def _on_command_long(session: Session, message: mavlink.MAVLink_command_long_message) -> None:
    """PX4 acknowledges a switch to OFFBOARD twice."""
    on_command_long(session, message)
    to_offboard = message.command == mavlink.MAV_CMD_DO_SET_MODE and message.param2 == _OFFBOARD_MAIN_MODE
    is_ours = session.accepts(message.target_system, message.target_component)
    if to_offboard and is_ours and session.firmware.mode is Mode.OFFBOARD:
        acknowledge(session, message, message.command, mavlink.MAV_RESULT_ACCEPTED)


def _on_global_setpoint(
    session: Session, message: mavlink.MAVLink_set_position_target_global_int_message
) -> None:
    local = as_local(session, message)
    if local is not None:
        _on_setpoint(session, local)
    elif session.accepts(message.target_system, message.target_component):
        frame = message.coordinate_frame
        session.say(Severity.CRITICAL, f"{message.msgname} coordinate frame {frame} unsupported")


def _on_setpoint(session: Session, message: mavlink.MAVLink_set_position_target_local_ned_message) -> None:
    if not session.accepts(message.target_system, message.target_component):
        return
    try:
        setpoint = read_setpoint(message, session.firmware.estimate.attitude)
    except SetpointRefusedError as refusal:
        session.say(Severity.CRITICAL, str(refusal))
    else:
        session.firmware.offboard_setpoint(setpoint)


PX4 = Flavour(
    autopilot=mavlink.MAV_AUTOPILOT_PX4,
    version=_VERSION,
    capabilities=_CAPABILITIES,
    links=(OFFBOARD, GROUND_STATION),
    mode_names={},
    custom_modes=_CUSTOM_MODES,
    modes={number: mode for mode, number in _CUSTOM_MODES.items()},
    base_mode=_base_mode,
    system_status=_system_status,
    results=_RESULTS,
    system_id_parameter="MAV_SYS_ID",
    earth_radius_m=PX4_EARTH_M,
    parameters=px4_parameters.WIRE,
    missions=PX4_MISSIONS,
    reached_repeats=10,
    tells_current_at_once=True,
    writers={
        **WRITERS,
        mavlink.MAVLINK_MSG_ID_MISSION_CURRENT: mission_telemetry.px4_mission_current,
        CURRENT_MODE: wellbeing.current_mode,
        mavlink.MAVLINK_MSG_ID_SYSTEM_TIME: wellbeing.system_time,
        mavlink.MAVLINK_MSG_ID_VIBRATION: wellbeing.vibration,
        mavlink.MAVLINK_MSG_ID_ESTIMATOR_STATUS: wellbeing.estimator_status,
        mavlink.MAVLINK_MSG_ID_POSITION_TARGET_LOCAL_NED: targets.position_target_local_ned,
        mavlink.MAVLINK_MSG_ID_ATTITUDE_TARGET: targets.attitude_target,
        mavlink.MAVLINK_MSG_ID_SERVO_OUTPUT_RAW: targets.servo_output_raw,
    },
    commands={
        **COMMANDS,
        **PX4_COMMANDS,
        **system_commands.PX4_COMMANDS,
        mavlink.MAV_CMD_NAV_TAKEOFF: _take_off,
        mavlink.MAV_CMD_DO_SET_MODE: _set_mode,
        mavlink.MAV_CMD_SET_MESSAGE_INTERVAL: _set_message_interval,
    },
    commands_to_all=(mavlink.MAV_CMD_REQUEST_MESSAGE, mavlink.MAV_CMD_REQUEST_PROTOCOL_VERSION),
    handlers={
        mavlink.MAVLINK_MSG_ID_SET_MODE: _on_set_mode,
        mavlink.MAVLINK_MSG_ID_PARAM_REQUEST_READ: px4_parameters.on_request_read,
        mavlink.MAVLINK_MSG_ID_PARAM_REQUEST_LIST: px4_parameters.on_request_list,
        mavlink.MAVLINK_MSG_ID_PARAM_SET: px4_parameters.on_set,
        mavlink.MAVLINK_MSG_ID_COMMAND_LONG: _on_command_long,
        mavlink.MAVLINK_MSG_ID_SET_POSITION_TARGET_LOCAL_NED: _on_setpoint,
        mavlink.MAVLINK_MSG_ID_SET_POSITION_TARGET_GLOBAL_INT: _on_global_setpoint,
    },
)
