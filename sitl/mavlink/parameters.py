"""The parameter protocol: PX4's encoding, the values that clients look at, all of them read-only."""

import struct

from pymavlink.dialects.v20 import common as mavlink

from sitl.mavlink.session import Session


def on_request_list(session: Session, message: mavlink.MAVLink_param_request_list_message) -> None:
    """Send every parameter."""
    if session.accepts(message.target_system, message.target_component):
        for name in session.parameters:
            _send(session, name)


def on_request_read(session: Session, message: mavlink.MAVLink_param_request_read_message) -> None:
    """Send one parameter, by index or, when that is -1, by name; an unknown one is not answered."""
    if not session.accepts(message.target_system, message.target_component):
        return
    names = list(session.parameters)
    if message.param_index == -1 and message.param_id in session.parameters:
        _send(session, message.param_id)
    elif 0 <= message.param_index < len(names):
        _send(session, names[message.param_index])


def on_set(session: Session, message: mavlink.MAVLink_param_set_message) -> None:
    """Answer with the value as it is: a client sees by it that its own was not taken."""
    known = message.param_id in session.parameters
    if known and session.accepts(message.target_system, message.target_component):
        _send(session, message.param_id)


def _send(session: Session, name: str) -> None:
    value, kind = _on_the_wire(session.parameters[name])
    session.send(
        mavlink.MAVLink_param_value_message(
            param_id=name.encode(),
            param_value=value,
            param_type=kind,
            param_count=len(session.parameters),
            param_index=list(session.parameters).index(name),
        )
    )


def _on_the_wire(value: float) -> tuple[float, int]:
    """The float field and the MAV_PARAM_TYPE; PX4 copies the four bytes of an integer into the field."""
    if not isinstance(value, int):
        return value, mavlink.MAV_PARAM_TYPE_REAL32
    (as_float,) = struct.unpack("<f", struct.pack("<i", value))
    return as_float, mavlink.MAV_PARAM_TYPE_INT32
