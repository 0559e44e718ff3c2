"""The parameter protocol: what the firmware flies by, listed, read and set."""

from collections.abc import Callable
from dataclasses import dataclass

from pymavlink.dialects.v20 import common as mavlink

from sitl.errors import ParameterRefusedError
from sitl.firmware.interface import Severity
from sitl.firmware.parameters import Stored
from sitl.mavlink.frames import Message
from sitl.mavlink.session import Session

NO_INDEX = 65535
_AT_ONCE = 5
"""How many of a list leave in one tick, as PX4 has it on UDP."""


@dataclass(frozen=True, eq=False)
class ParameterWire:
    """How an autopilot puts parameters into messages.

    Attributes:
        encode: the float field and the MAV_PARAM_TYPE of a value.
        decode: the value in a float field of a MAV_PARAM_TYPE; None when the types do not match.
        says_index: whether an answer to a name has the parameter's index.
    """

    encode: Callable[[Stored, float], tuple[float, int]]
    decode: Callable[[Stored, float, int], float | None]
    says_index: bool


def names(session: Session) -> list[str]:
    """All parameters, in the order of their indices."""
    return sorted(type(session.firmware.parameters).model_fields)


def on_request_list(session: Session, message: mavlink.MAVLink_param_request_list_message) -> None:
    """Begin to send every parameter, a few with each tick."""
    if session.accepts(message.target_system, message.target_component):
        session.backlog.clear()
        session.backlog.extend(enumerate(names(session)))


def send_backlog(session: Session) -> None:
    """Send the next few of a list that was asked for."""
    for _ in range(min(_AT_ONCE, len(session.backlog))):
        index, name = session.backlog.popleft()
        session.send(_value(session, name, index))


def on_request_read(session: Session, message: mavlink.MAVLink_param_request_read_message) -> None:
    """Send one parameter, by index or, when that is -1, by name; an unknown one is not answered."""
    if not session.accepts(message.target_system, message.target_component):
        return
    known = names(session)
    if message.param_index == -1 and message.param_id in known:
        send_named(session, message.param_id)
    elif 0 <= message.param_index < len(known):
        session.send(_value(session, known[message.param_index], message.param_index))


def on_set(session: Session, message: mavlink.MAVLink_param_set_message) -> None:
    """Set one, and answer with what it is then: a client sees by the old value that its own is refused."""
    name = message.param_id
    if name not in names(session) or not session.accepts(message.target_system, message.target_component):
        return
    stored = session.firmware.parameters.stored(name)
    value = session.flavour.parameters.decode(stored, message.param_value, message.param_type)
    if value is None:
        return  # PX4 does not answer a wrong type
    try:
        session.firmware.set_parameter(name, value)
    except ParameterRefusedError as refusal:
        session.say(Severity.WARNING, str(refusal))
    send_named(session, name)


def send_named(session: Session, name: str) -> None:
    """Send the parameter of that name."""
    says_index = session.flavour.parameters.says_index
    session.send(_value(session, name, names(session).index(name) if says_index else NO_INDEX))


def _value(session: Session, name: str, index: int) -> Message:
    parameters = session.firmware.parameters
    value, kind = session.flavour.parameters.encode(parameters.stored(name), getattr(parameters, name))
    return mavlink.MAVLink_param_value_message(
        param_id=name.encode(),
        param_value=value,
        param_type=kind,
        param_count=len(type(parameters).model_fields),
        param_index=index,
    )
