"""ArduPilot Copter as it speaks MAVLink."""

import math
from collections.abc import Mapping

from pymavlink.dialects.v20 import common as mavlink

from sitl.firmware.ardupilot_modes import MODE_NAMES
from sitl.firmware.interface import Autopilot, Landed, Mode, Result
from sitl.geodesy import ARDUPILOT_EARTH_M
from sitl.mavlink import (
    ardupilot_parameters,
    guided_commands,
    mission_telemetry,
    missions,
    sticks,
    system_commands,
    targets,
    wellbeing,
)
from sitl.mavlink.commands import COMMANDS, Command, acknowledge, set_mode, whole
from sitl.mavlink.flavour import Execute, Flavour
from sitl.mavlink.global_setpoints import as_local
from sitl.mavlink.guided_setpoints import read_guided_setpoint
from sitl.mavlink.links import CURRENT_MODE, TELEMETRY
from sitl.mavlink.mission_commands import ARDUPILOT_COMMANDS
from sitl.mavlink.mission_wires import ARDUPILOT_MISSIONS
from sitl.mavlink.session import Session
from sitl.mavlink.telemetry import WRITERS, Report, home_position

_VERSION = 4 << 24 | 6 << 16 | 0 << 8 | mavlink.FIRMWARE_VERSION_TYPE_OFFICIAL
_CAPABILITIES = (
    mavlink.MAV_PROTOCOL_CAPABILITY_MISSION_FLOAT
    | mavlink.MAV_PROTOCOL_CAPABILITY_PARAM_FLOAT
    | mavlink.MAV_PROTOCOL_CAPABILITY_MISSION_INT
    | mavlink.MAV_PROTOCOL_CAPABILITY_COMMAND_INT
    | mavlink.MAV_PROTOCOL_CAPABILITY_SET_POSITION_TARGET_LOCAL_NED
    | mavlink.MAV_PROTOCOL_CAPABILITY_SET_POSITION_TARGET_GLOBAL_INT
    | mavlink.MAV_PROTOCOL_CAPABILITY_FLIGHT_TERMINATION
    | mavlink.MAV_PROTOCOL_CAPABILITY_MAVLINK2
    | mavlink.MAV_PROTOCOL_CAPABILITY_MISSION_FENCE
    | mavlink.MAV_PROTOCOL_CAPABILITY_MISSION_RALLY
)
_RESULTS = {
    Result.ACCEPTED: mavlink.MAV_RESULT_ACCEPTED,
    Result.TEMPORARILY_REJECTED: mavlink.MAV_RESULT_FAILED,
    Result.DENIED: mavlink.MAV_RESULT_DENIED,
    Result.FAILED: mavlink.MAV_RESULT_FAILED,
}

_CUSTOM_MODES = {
    Mode.STABILIZE: 0,
    Mode.MISSION: 3,
    Mode.OFFBOARD: 4,
    Mode.HOLD: 5,
    Mode.RTL: 6,
    Mode.LAND: 9,
    Mode.BRAKE: 17,
}

_STREAMS: Mapping[int, tuple[int, ...]] = {
    mavlink.MAV_DATA_STREAM_EXTENDED_STATUS: (
        mavlink.MAVLINK_MSG_ID_SYS_STATUS,
        mavlink.MAVLINK_MSG_ID_GPS_RAW_INT,
        mavlink.MAVLINK_MSG_ID_MISSION_CURRENT,
        mission_telemetry.FENCE_STATUS,
    ),
    mavlink.MAV_DATA_STREAM_POSITION: (
        mavlink.MAVLINK_MSG_ID_GLOBAL_POSITION_INT,
        mavlink.MAVLINK_MSG_ID_LOCAL_POSITION_NED,
    ),
    mavlink.MAV_DATA_STREAM_EXTRA1: (mavlink.MAVLINK_MSG_ID_ATTITUDE,),
    mavlink.MAV_DATA_STREAM_EXTRA2: (mavlink.MAVLINK_MSG_ID_VFR_HUD,),
    mavlink.MAV_DATA_STREAM_EXTRA3: (
        mavlink.MAVLINK_MSG_ID_SYSTEM_TIME,
        mavlink.MAVLINK_MSG_ID_BATTERY_STATUS,
        mavlink.MAVLINK_MSG_ID_VIBRATION,
        wellbeing.EKF_STATUS_REPORT,
    ),
    mavlink.MAV_DATA_STREAM_RC_CHANNELS: (
        mavlink.MAVLINK_MSG_ID_SERVO_OUTPUT_RAW,
        mavlink.MAVLINK_MSG_ID_RC_CHANNELS,
    ),
}
"""The messages in each stream, as far as they are told here."""


def _base_mode(mode: Mode, armed: bool) -> int:
    flags = (
        mavlink.MAV_MODE_FLAG_CUSTOM_MODE_ENABLED
        | mavlink.MAV_MODE_FLAG_MANUAL_INPUT_ENABLED
        | mavlink.MAV_MODE_FLAG_STABILIZE_ENABLED
    )
    if mode is not Mode.STABILIZE:
        flags |= mavlink.MAV_MODE_FLAG_GUIDED_ENABLED  # the position controller runs
    return flags | mavlink.MAV_MODE_FLAG_SAFETY_ARMED if armed else flags


def _system_status(firmware: Autopilot) -> int:
    if firmware.failsafe:
        return mavlink.MAV_STATE_CRITICAL
    on_ground = firmware.landed is Landed.ON_GROUND
    return mavlink.MAV_STATE_STANDBY if on_ground else mavlink.MAV_STATE_ACTIVE


def _set_mode(session: Session, command: Command) -> int:
    return set_mode(session, whole(command.params[0]), whole(command.params[1]))


def _on_set_mode(session: Session, message: mavlink.MAVLink_set_mode_message) -> None:
    """Answer a SET_MODE by its message id in the place of a command, as ArduPilot does."""
    if message.target_system == session.system_id:
        result = set_mode(session, message.base_mode, message.custom_mode)
        acknowledge(session, message, mavlink.MAVLINK_MSG_ID_SET_MODE, result)


def _take_off(session: Session, command: Command) -> int:
    """To an altitude above home; a place on the map means nothing."""
    if command.frame not in (None, mavlink.MAV_FRAME_GLOBAL_RELATIVE_ALT):
        return mavlink.MAV_RESULT_DENIED
    if not math.isfinite(command.place.altitude_m):
        return mavlink.MAV_RESULT_FAILED
    return session.result(session.firmware.takeoff(command.place.altitude_m))


def _on_setpoint(session: Session, message: mavlink.MAVLink_set_position_target_local_ned_message) -> None:
    """Outside GUIDED a setpoint is dropped without a word."""
    is_ours = session.accepts(message.target_system, message.target_component)
    if is_ours and session.firmware.mode is Mode.OFFBOARD:
        session.firmware.offboard_setpoint(read_guided_setpoint(message, session.firmware.estimate))


def _on_global_setpoint(
    session: Session, message: mavlink.MAVLink_set_position_target_global_int_message
) -> None:
    """One whose place cannot be told is dropped like one in another mode."""
    local = as_local(session, message)
    if local is not None:
        _on_setpoint(session, local)


def _on_request_data_stream(session: Session, message: mavlink.MAVLink_request_data_stream_message) -> None:
    """Start or stop a stream of messages; MAV_DATA_STREAM_ALL is each of them."""
    if not session.accepts(message.target_system, message.target_component):
        return
    wanted = message.start_stop and message.req_message_rate
    interval_us = round(1e6 / message.req_message_rate) if wanted else -1
    all_streams = message.req_stream_id == mavlink.MAV_DATA_STREAM_ALL
    for stream in _STREAMS if all_streams else (message.req_stream_id,):
        for message_id in _STREAMS.get(stream, ()):
            session.streams.set_interval(message_id, interval_us, round(session.time_s * 1e6))


_COMMANDS: Mapping[int, Execute] = {
    **COMMANDS,
    **ARDUPILOT_COMMANDS,
    **system_commands.ARDUPILOT_COMMANDS,
    **guided_commands.COMMANDS,
    mavlink.MAV_CMD_NAV_TAKEOFF: _take_off,
    mavlink.MAV_CMD_DO_SET_MODE: _set_mode,
}


def _home_position(state: Report) -> mavlink.MAVLink_home_position_message:
    """HOME_POSITION, whose local coordinates ArduPilot leaves at 0."""
    message = home_position(state)
    message.x = message.y = message.z = 0.0
    return message


ARDUPILOT = Flavour(
    autopilot=mavlink.MAV_AUTOPILOT_ARDUPILOTMEGA,
    version=_VERSION,
    capabilities=_CAPABILITIES,
    links=(TELEMETRY,),
    mode_names=MODE_NAMES,
    custom_modes=_CUSTOM_MODES,
    modes={number: mode for mode, number in _CUSTOM_MODES.items()},
    base_mode=_base_mode,
    system_status=_system_status,
    results=_RESULTS,
    system_id_parameter="SYSID_THISMAV",
    earth_radius_m=ARDUPILOT_EARTH_M,
    parameters=ardupilot_parameters.WIRE,
    missions=ARDUPILOT_MISSIONS,
    reached_repeats=0,
    tells_current_at_once=False,
    writers={
        **WRITERS,
        mavlink.MAVLINK_MSG_ID_HOME_POSITION: _home_position,
        mavlink.MAVLINK_MSG_ID_MISSION_CURRENT: mission_telemetry.ardupilot_mission_current,
        mission_telemetry.FENCE_STATUS: mission_telemetry.fence_status,
        CURRENT_MODE: wellbeing.current_mode,
        mavlink.MAVLINK_MSG_ID_SYSTEM_TIME: wellbeing.system_time,
        mavlink.MAVLINK_MSG_ID_VIBRATION: wellbeing.vibration,
        mavlink.MAVLINK_MSG_ID_POSITION_TARGET_LOCAL_NED: targets.position_target_local_ned,
        mavlink.MAVLINK_MSG_ID_ATTITUDE_TARGET: targets.attitude_target,
        mavlink.MAVLINK_MSG_ID_SERVO_OUTPUT_RAW: targets.servo_output_raw,
        mavlink.MAVLINK_MSG_ID_RC_CHANNELS: sticks.rc_channels,
        wellbeing.EKF_STATUS_REPORT: wellbeing.ekf_status_report,
    },
    commands=_COMMANDS,
    commands_to_all=_COMMANDS,
    handlers={
        mavlink.MAVLINK_MSG_ID_MISSION_WRITE_PARTIAL_LIST: missions.on_write_partial_list,
        mavlink.MAVLINK_MSG_ID_SET_MODE: _on_set_mode,
        mavlink.MAVLINK_MSG_ID_REQUEST_DATA_STREAM: _on_request_data_stream,
        mavlink.MAVLINK_MSG_ID_MISSION_ITEM: guided_commands.on_item,
        mavlink.MAVLINK_MSG_ID_MISSION_ITEM_INT: guided_commands.on_item_int,
        mavlink.MAVLINK_MSG_ID_SET_POSITION_TARGET_LOCAL_NED: _on_setpoint,
        mavlink.MAVLINK_MSG_ID_SET_POSITION_TARGET_GLOBAL_INT: _on_global_setpoint,
    },
)
