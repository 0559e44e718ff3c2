"""The mission protocol of a vehicle that holds no plan: quick answers, so that no client waits."""

from pymavlink.dialects.v20 import common as mavlink

from sitl.mavlink.session import Session


def on_request_list(session: Session, message: mavlink.MAVLink_mission_request_list_message) -> None:
    """Nothing to download."""
    if session.accepts(message.target_system, message.target_component):
        session.send(
            mavlink.MAVLink_mission_count_message(
                message.get_srcSystem(), message.get_srcComponent(), 0, message.mission_type
            )
        )


def on_count(session: Session, message: mavlink.MAVLink_mission_count_message) -> None:
    """An upload is refused, unless it has no items."""
    accepted = mavlink.MAV_MISSION_ACCEPTED if message.count == 0 else mavlink.MAV_MISSION_UNSUPPORTED
    _acknowledge(session, message, accepted)


def on_clear_all(session: Session, message: mavlink.MAVLink_mission_clear_all_message) -> None:
    """Clearing nothing succeeds."""
    _acknowledge(session, message, mavlink.MAV_MISSION_ACCEPTED)


def _acknowledge(
    session: Session,
    message: mavlink.MAVLink_mission_count_message | mavlink.MAVLink_mission_clear_all_message,
    result: int,
) -> None:
    if session.accepts(message.target_system, message.target_component):
        session.send(
            mavlink.MAVLink_mission_ack_message(
                message.get_srcSystem(), message.get_srcComponent(), result, message.mission_type
            )
        )
