"""The parameter protocol: the values that act on the firmware, all of them read-only."""

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
    value, kind = session.flavour.encode_parameter(session.parameters[name])
    session.send(
        mavlink.MAVLink_param_value_message(
            param_id=name.encode(),
            param_value=value,
            param_type=kind,
            param_count=len(session.parameters),
            param_index=list(session.parameters).index(name),
        )
    )
