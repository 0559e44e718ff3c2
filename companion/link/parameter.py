"""The vehicle's parameters, read by name: https://mavlink.io/en/services/parameter.html."""

import struct

from companion.errors import NoReplyError
from companion.link.connection import Connection
from companion.link.dialect import mavlink

_INTEGERS = {
    mavlink.MAV_PARAM_TYPE_UINT8: "<B3x",
    mavlink.MAV_PARAM_TYPE_INT8: "<b3x",
    mavlink.MAV_PARAM_TYPE_UINT16: "<H2x",
    mavlink.MAV_PARAM_TYPE_INT16: "<h2x",
    mavlink.MAV_PARAM_TYPE_UINT32: "<I",
    mavlink.MAV_PARAM_TYPE_INT32: "<i",
}


async def read_parameter(
    connection: Connection, name: str, *, attempt_timeout_s: float = 0.5, attempts: int = 3
) -> float:
    """The value of a parameter, in the parameter's own unit; an integer one as a whole number.

    Raises:
        NoReplyError: the vehicle did not answer: it may have no such parameter.
    """
    request = mavlink.MAVLink_param_request_read_message(
        *connection.target, param_id=name.encode("ascii"), param_index=-1
    )
    for _ in range(attempts):
        connection.send(request)
        try:
            answer = await connection.receive(
                mavlink.MAVLink_param_value_message,
                lambda message: message.param_id == name,
                timeout_s=attempt_timeout_s,
            )
        except NoReplyError:
            continue
        # PX4 copies an integer's bytes into the float field; ArduPilot converts the number.
        bytewise = connection.heartbeat.autopilot == mavlink.MAV_AUTOPILOT_PX4
        return _from_bytes(answer) if bytewise else answer.param_value
    raise NoReplyError(f"the vehicle did not answer for parameter {name}: it may have none of that name")


def _from_bytes(answer: mavlink.MAVLink_param_value_message) -> float:
    layout = _INTEGERS.get(answer.param_type)
    if layout is None:
        return answer.param_value
    (value,) = struct.unpack(layout, struct.pack("<f", answer.param_value))
    return float(value)
