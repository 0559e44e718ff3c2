"""Which message is answered by whom: add a service by adding its messages here."""

from collections.abc import Mapping

from pymavlink.dialects.v20 import common as mavlink

from sitl.mavlink import commands, missions, parameters, sticks
from sitl.mavlink.flavour import Handle
from sitl.mavlink.frames import Message
from sitl.mavlink.session import Session
from sitl.mavlink.telemetry import written


def handle(session: Session, message: Message) -> None:
    """Do what a message asks for; one that the vehicle does not know is ignored."""
    number = message.get_msgId()
    handler = session.flavour.handlers.get(number) or _HANDLERS.get(number)
    if handler:
        handler(session, message)


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


def _on_heartbeat(session: Session, message: mavlink.MAVLink_heartbeat_message) -> None:
    """A ground station is there."""
    if message.type == mavlink.MAV_TYPE_GCS:
        session.firmware.hear_ground_station(message.get_srcSystem())


def _on_set_origin(session: Session, message: mavlink.MAVLink_set_gps_global_origin_message) -> None:
    """The receiver has set the origin already: the answer says where."""
    if message.target_system == session.system_id:
        origin = written(mavlink.MAVLINK_MSG_ID_GPS_GLOBAL_ORIGIN, session.report())
        if origin is not None:
            session.send(origin)


_HANDLERS: Mapping[int, Handle] = {
    mavlink.MAVLINK_MSG_ID_HEARTBEAT: _on_heartbeat,
    mavlink.MAVLINK_MSG_ID_MANUAL_CONTROL: sticks.on_manual_control,
    mavlink.MAVLINK_MSG_ID_RC_CHANNELS_OVERRIDE: sticks.on_channels_override,
    mavlink.MAVLINK_MSG_ID_SET_GPS_GLOBAL_ORIGIN: _on_set_origin,
    mavlink.MAVLINK_MSG_ID_PING: _on_ping,
    mavlink.MAVLINK_MSG_ID_PARAM_REQUEST_READ: parameters.on_request_read,
    mavlink.MAVLINK_MSG_ID_PARAM_REQUEST_LIST: parameters.on_request_list,
    mavlink.MAVLINK_MSG_ID_PARAM_SET: parameters.on_set,
    mavlink.MAVLINK_MSG_ID_MISSION_REQUEST_LIST: missions.on_request_list,
    mavlink.MAVLINK_MSG_ID_MISSION_REQUEST: missions.on_request,
    mavlink.MAVLINK_MSG_ID_MISSION_REQUEST_INT: missions.on_request_int,
    mavlink.MAVLINK_MSG_ID_MISSION_COUNT: missions.on_count,
    mavlink.MAVLINK_MSG_ID_MISSION_ITEM: missions.on_item,
    mavlink.MAVLINK_MSG_ID_MISSION_ITEM_INT: missions.on_item_int,
    mavlink.MAVLINK_MSG_ID_MISSION_ACK: missions.on_ack,
    mavlink.MAVLINK_MSG_ID_MISSION_SET_CURRENT: missions.on_set_current,
    mavlink.MAVLINK_MSG_ID_MISSION_CLEAR_ALL: missions.on_clear_all,
    mavlink.MAVLINK_MSG_ID_COMMAND_INT: commands.on_command_int,
    mavlink.MAVLINK_MSG_ID_COMMAND_LONG: commands.on_command_long,
    mavlink.MAVLINK_MSG_ID_TIMESYNC: _on_timesync,
}
"""What every autopilot does with a message, by message id; the session's flavour has the rest."""
