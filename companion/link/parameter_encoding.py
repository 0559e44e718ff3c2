"""Parameters on the wire: every value travels in one float field, integers in one of two ways.

Source: https://mavlink.io/en/services/parameter.html#parameter-encoding
"""

import math
import struct
from dataclasses import dataclass
from enum import Enum, IntEnum, auto
from typing import TypeAlias

from companion.errors import NoReplyError
from companion.link.command import request_message
from companion.link.connection import Connection
from companion.link.dialect import mavlink

Number: TypeAlias = int | float

_LONGEST_NAME = 16


class ParameterType(IntEnum):
    """MAV_PARAM_TYPE, of those that fit into the protocol's float field."""

    UINT8 = mavlink.MAV_PARAM_TYPE_UINT8
    INT8 = mavlink.MAV_PARAM_TYPE_INT8
    UINT16 = mavlink.MAV_PARAM_TYPE_UINT16
    INT16 = mavlink.MAV_PARAM_TYPE_INT16
    UINT32 = mavlink.MAV_PARAM_TYPE_UINT32
    INT32 = mavlink.MAV_PARAM_TYPE_INT32
    REAL32 = mavlink.MAV_PARAM_TYPE_REAL32

    @property
    def is_integer(self) -> bool:
        """Whether values are whole numbers."""
        return self is not ParameterType.REAL32

    def holds(self, value: Number) -> bool:
        """Whether `value` is one of this type: within its range, and whole where that is asked for."""
        if not self.is_integer:
            return True
        low, high = _RANGES[self]
        return float(value).is_integer() and low <= value <= high


class Encoding(Enum):
    """How an integer travels in the float field."""

    BYTEWISE = auto()
    """Its bytes are copied, as PX4 does."""
    CAST = auto()
    """Its number is converted, as ArduPilot does."""


@dataclass(frozen=True, slots=True)
class Parameter:
    """One parameter of a vehicle.

    Attributes:
        name: at most 16 characters.
        value: in the parameter's own unit; an int for an integer type.
        type: how the vehicle keeps it.
    """

    name: str
    value: Number
    type: ParameterType


def usual_encoding(autopilot: int) -> Encoding:
    """What a MAV_AUTOPILOT uses that does not say."""
    return Encoding.BYTEWISE if autopilot == mavlink.MAV_AUTOPILOT_PX4 else Encoding.CAST


async def parameter_encoding(connection: Connection) -> Encoding:
    """What the connection's vehicle uses: by AUTOPILOT_VERSION.capabilities, or else by its autopilot."""
    try:
        told = await request_message(connection, mavlink.MAVLink_autopilot_version_message)
    except NoReplyError:
        return usual_encoding(connection.heartbeat.autopilot)
    if told.capabilities & mavlink.MAV_PROTOCOL_CAPABILITY_PARAM_ENCODE_BYTEWISE:
        return Encoding.BYTEWISE
    if told.capabilities & mavlink.MAV_PROTOCOL_CAPABILITY_PARAM_ENCODE_C_CAST:
        return Encoding.CAST
    return usual_encoding(connection.heartbeat.autopilot)


def decode_value(field: float, kind: ParameterType, encoding: Encoding) -> Number:
    """The value that PARAM_VALUE.param_value stands for."""
    if not kind.is_integer:
        return field
    if encoding is Encoding.CAST:
        return round(field) if math.isfinite(field) else field
    (value,) = struct.unpack(_LAYOUTS[kind], struct.pack("<f", field))
    return int(value)


def encode_value(value: Number, kind: ParameterType, encoding: Encoding) -> float:
    """The float field in which `value` travels; it must be one that `kind` holds."""
    if not kind.is_integer or encoding is Encoding.CAST:
        return float(value)
    (field,) = struct.unpack("<f", struct.pack(_LAYOUTS[kind], int(value)))
    return float(field)


def wire_name(name: str) -> bytes:
    """A name as PARAM_SET and PARAM_REQUEST_READ carry it: 16 bytes, not terminated where it fills them."""
    return name.encode("ascii")[:_LONGEST_NAME]


_LAYOUTS = {
    ParameterType.UINT8: "<B3x",
    ParameterType.INT8: "<b3x",
    ParameterType.UINT16: "<H2x",
    ParameterType.INT16: "<h2x",
    ParameterType.UINT32: "<I",
    ParameterType.INT32: "<i",
}
_RANGES = {
    ParameterType.UINT8: (0, 2**8 - 1),
    ParameterType.INT8: (-(2**7), 2**7 - 1),
    ParameterType.UINT16: (0, 2**16 - 1),
    ParameterType.INT16: (-(2**15), 2**15 - 1),
    ParameterType.UINT32: (0, 2**32 - 1),
    ParameterType.INT32: (-(2**31), 2**31 - 1),
}
