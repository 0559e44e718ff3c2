"""The vehicle's parameters, by name: https://mavlink.io/en/services/parameter.html."""

import math
import struct
from collections.abc import Callable, Iterable, Mapping
from functools import partial

from companion.errors import NoReplyError
from companion.link.connection import Connection
from companion.link.dialect import Message, mavlink
from companion.link.parameter_encoding import (
    Encoding,
    Number,
    Parameter,
    ParameterType,
    decode_value,
    encode_value,
    usual_encoding,
    wire_name,
)
from companion.link.parameter_exchange import Exchange

_ROUNDS = 4
"""How often to set what was read back otherwise: the read-back may have been a frame that came late."""
_PROBES = 5
"""How often to ask for a parameter that may not exist: PX4 before 1.17 and ArduPilot are then silent."""


async def read_parameter(
    connection: Connection, name: str, *, attempt_timeout_s: float = 0.5, attempts: int = 3
) -> Number:
    """The value of a parameter, in the parameter's own unit; an integer one as a whole number.

    Raises:
        NoReplyError: the vehicle did not answer: it may have no such parameter.
    """
    encoding = usual_encoding(connection.heartbeat.autopilot)
    for _ in range(attempts):
        connection.send(_read_request(connection, name))
        try:
            answer = await connection.receive(
                mavlink.MAVLink_param_value_message,
                lambda message: message.param_id == name,
                timeout_s=attempt_timeout_s,
            )
        except NoReplyError:
            continue
        return parameter_in(answer, encoding).value
    raise NoReplyError(f"the vehicle did not answer for parameter {name}: it may have none of that name")


async def read_parameters(
    connection: Connection, names: Iterable[str], encoding: Encoding, *, attempts: int = _PROBES
) -> dict[str, Parameter]:
    """Those of the parameters that the vehicle has, in the order of `names`."""
    names = tuple(names)
    found: dict[str, Parameter] = {}
    exchange = Exchange(
        names, lambda name: connection.send(_read_request(connection, name)), attempts=attempts
    )

    def take(message: mavlink.MAVLink_param_value_message) -> None:
        if message.param_id in exchange.unanswered:
            found[message.param_id] = parameter_in(message, encoding)
            exchange.answered(message.param_id)

    unsubscribe = (
        connection.subscribe(mavlink.MAVLink_param_value_message, take),
        connection.subscribe(
            mavlink.MAVLink_param_error_message, lambda message: exchange.answered(message.param_id)
        ),
    )
    try:
        await exchange.run()
    finally:
        for end in unsubscribe:
            end()
    return {name: found[name] for name in names if name in found}


async def set_parameters(
    connection: Connection,
    wanted: Iterable[Parameter],
    encoding: Encoding,
    *,
    progress: Callable[[int], None] = lambda done: None,
) -> dict[str, str]:
    """Set parameters, and read each back; those that differ are set again, a few times.

    Args:
        connection: to the vehicle.
        wanted: names, values and types; the types must be the vehicle's own.
        encoding: the vehicle's.
        progress: told how many the vehicle has answered, and at last how many it has taken.

    Returns:
        What the vehicle did not take, by name, with the reason in words.
    """
    left = {parameter.name: parameter for parameter in wanted}
    total, reasons = len(left), dict[str, str]()
    for _ in range(_ROUNDS):
        count = partial(_count_on, progress, total - len(left))
        reasons = await _send_settings(connection, left, encoding, count)
        kept = await read_parameters(connection, left, encoding)
        for name, parameter in list(left.items()):
            if name in kept and same_value(kept[name].value, parameter.value):
                del left[name]
            elif name in kept:
                reasons.setdefault(name, f"it keeps {kept[name].value:g}")
        progress(total - len(left))
        if not left:
            break
    return {name: reasons.get(name, "it does not answer") for name in left}


def same_value(one: Number, other: Number) -> bool:
    """Whether two values are the same to a vehicle, which keeps them in 32 bits."""
    if isinstance(one, int) and isinstance(other, int):
        return one == other
    if math.isnan(one) or math.isnan(other):
        return math.isnan(one) and math.isnan(other)
    # One unit in the last place of a float32: what a value written with few digits may be off by.
    return math.isclose(_float32(one), _float32(other), rel_tol=2.0**-23, abs_tol=1e-38)


def parameter_in(message: mavlink.MAVLink_param_value_message, encoding: Encoding) -> Parameter:
    """The parameter that a PARAM_VALUE tells of; one of a type that is no such is taken for a float."""
    known = message.param_type in _KINDS
    kind = ParameterType(message.param_type) if known else ParameterType.REAL32
    return Parameter(message.param_id, decode_value(message.param_value, kind, encoding), kind)


async def _send_settings(
    connection: Connection,
    wanted: Mapping[str, Parameter],
    encoding: Encoding,
    progress: Callable[[int], None],
) -> dict[str, str]:
    """Send each until something comes back for it; the errors that came back, by name."""
    errors: dict[str, str] = {}

    def ask(name: str) -> None:
        parameter = wanted[name]
        field = encode_value(parameter.value, parameter.type, encoding)
        connection.send(
            mavlink.MAVLink_param_set_message(*connection.target, wire_name(name), field, parameter.type)
        )

    exchange = Exchange(wanted, ask)

    def take(message: mavlink.MAVLink_param_value_message) -> None:
        exchange.answered(message.param_id)
        progress(len(wanted) - len(exchange.unanswered))

    def refuse(message: mavlink.MAVLink_param_error_message) -> None:
        entry = mavlink.enums["MAV_PARAM_ERROR"].get(message.error)
        name = entry.name.removeprefix("MAV_PARAM_ERROR_") if entry else f"error {message.error}"
        if message.param_id in exchange.unanswered:
            errors[message.param_id] = f"it says {name}"
        exchange.answered(message.param_id)

    unsubscribe = (
        connection.subscribe(mavlink.MAVLink_param_value_message, take),
        connection.subscribe(mavlink.MAVLink_param_error_message, refuse),
    )
    try:
        await exchange.run()
    finally:
        for end in unsubscribe:
            end()
    return errors


def _count_on(progress: Callable[[int], None], already: int, done: int) -> None:
    progress(already + done)


def _read_request(connection: Connection, name: str) -> Message:
    return mavlink.MAVLink_param_request_read_message(
        *connection.target, param_id=wire_name(name), param_index=-1
    )


def _float32(value: Number) -> float:
    try:
        (rounded,) = struct.unpack("<f", struct.pack("<f", value))
    except OverflowError:
        return math.copysign(math.inf, value)
    return float(rounded)


_KINDS = frozenset(ParameterType)
