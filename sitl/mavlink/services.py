"""Which message is answered by whom: add a service by adding its messages here."""

from collections.abc import Callable, Mapping
from typing import Any

from pymavlink.dialects.v20 import common as mavlink

from sitl.firmware.interface import Severity
from sitl.mavlink import commands, missions, parameters
from sitl.mavlink.frames import Message
from sitl.mavlink.session import Session
from sitl.mavlink.setpoints import SetpointRefusedError, read_setpoint


def handle(session: Session, message: Message) -> None:
    """Do what a message asks for; one that the vehicle does not know is ignored, as in PX4."""
    handler = _HANDLERS.get(message.get_msgId())
    if handler:
        handler(session, message)


def _on_setpoint(session: Session, message: mavlink.MAVLink_set_position_target_local_ned_message) -> None:
    if not session.accepts(message.target_system, message.target_component):
        return
    try:
        setpoint = read_setpoint(message, session.firmware.estimate.attitude)
    except SetpointRefusedError as refusal:
        session.say(Severity.CRITICAL, str(refusal))
    else:
        session.firmware.offboard_setpoint(setpoint)


def _on_timesync(session: Session, message: mavlink.MAVLink_timesync_message) -> None:
    """A request has tc1 = 0; the vehicle's clock is the time since boot (ns)."""
    if message.tc1 == 0:
        session.send(mavlink.MAVLink_timesync_message(tc1=round(session.time_s * 1e9), ts1=message.ts1))


def _on_ping(session: Session, message: mavlink.MAVLink_ping_message) -> None:
    """A request is to everyone; its answer goes to the sender."""
    if message.target_system == message.target_component == 0:
        session.send(
            mavlink.MAVLink_ping_message(
                message.time_usec, message.seq, message.get_srcSystem(), message.get_srcComponent()
            )
        )


_HANDLERS: Mapping[int, Callable[[Session, Any], None]] = {
    mavlink.MAVLINK_MSG_ID_PING: _on_ping,
    mavlink.MAVLINK_MSG_ID_SET_MODE: commands.on_set_mode,
    mavlink.MAVLINK_MSG_ID_PARAM_REQUEST_READ: parameters.on_request_read,
    mavlink.MAVLINK_MSG_ID_PARAM_REQUEST_LIST: parameters.on_request_list,
    mavlink.MAVLINK_MSG_ID_PARAM_SET: parameters.on_set,
    mavlink.MAVLINK_MSG_ID_MISSION_REQUEST_LIST: missions.on_request_list,
    mavlink.MAVLINK_MSG_ID_MISSION_COUNT: missions.on_count,
    mavlink.MAVLINK_MSG_ID_MISSION_CLEAR_ALL: missions.on_clear_all,
    mavlink.MAVLINK_MSG_ID_COMMAND_INT: commands.on_command_int,
    mavlink.MAVLINK_MSG_ID_COMMAND_LONG: commands.on_command_long,
    mavlink.MAVLINK_MSG_ID_SET_POSITION_TARGET_LOCAL_NED: _on_setpoint,
    mavlink.MAVLINK_MSG_ID_TIMESYNC: _on_timesync,
}
"""Handlers by message id; each takes the session and the message."""
