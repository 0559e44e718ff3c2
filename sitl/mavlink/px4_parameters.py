"""Parameters as PX4 sends them: the bytes of a value, and a hash of them all (its mavlink_parameters.cpp)."""

import struct
import zlib

from pymavlink.dialects.v20 import common as mavlink

from sitl.firmware.parameters import Parameters, Stored
from sitl.mavlink import parameters
from sitl.mavlink.parameters import NO_INDEX, ParameterWire
from sitl.mavlink.session import Session

_HASH = "_HASH_CHECK"
_TYPES = {True: mavlink.MAV_PARAM_TYPE_REAL32, False: mavlink.MAV_PARAM_TYPE_INT32}


def _bytes(stored: Stored, value: float) -> bytes:
    return struct.pack("<f", value) if stored is Stored.FLOAT else struct.pack("<i", int(value))


def _encode(stored: Stored, value: float) -> tuple[float, int]:
    """The four bytes of an integer go into the float field as they are."""
    (as_float,) = struct.unpack("<f", _bytes(stored, value))
    return as_float, _TYPES[stored is Stored.FLOAT]


def _decode(stored: Stored, field: float, kind: int) -> float | None:
    if kind != _TYPES[stored is Stored.FLOAT]:
        return None
    if stored is Stored.FLOAT:
        return field
    (value,) = struct.unpack("<i", struct.pack("<f", field))
    return int(value)


WIRE = ParameterWire(_encode, _decode, says_index=True)


def parameter_hash(values: Parameters) -> int:
    """By which a client knows its cache: CRC-32, not inverted, over the names and bytes of all parameters."""
    crc = 0xFFFFFFFF
    for name in sorted(type(values).model_fields):
        crc = zlib.crc32(name.encode() + _bytes(values.stored(name), getattr(values, name)), crc)
    return crc ^ 0xFFFFFFFF


def on_request_list(session: Session, message: mavlink.MAVLink_param_request_list_message) -> None:
    """The hash comes first."""
    if session.accepts(message.target_system, message.target_component):
        _send_hash(session)
        parameters.on_request_list(session, message)


def on_request_read(session: Session, message: mavlink.MAVLink_param_request_read_message) -> None:
    """The hash has a name like a parameter."""
    asks_for_hash = message.param_index < 0 and message.param_id == _HASH
    if asks_for_hash and session.accepts(message.target_system, message.target_component):
        _send_hash(session)
    else:
        parameters.on_request_read(session, message)


def on_set(session: Session, message: mavlink.MAVLink_param_set_message) -> None:
    """Who sets the hash has everything in its cache: the list ends."""
    if message.param_id != _HASH:
        parameters.on_set(session, message)
    elif session.accepts(message.target_system, message.target_component):
        session.backlog.clear()


def _send_hash(session: Session) -> None:
    values = session.firmware.parameters
    (as_float,) = struct.unpack("<f", struct.pack("<I", parameter_hash(values)))
    session.send(
        mavlink.MAVLink_param_value_message(
            param_id=_HASH.encode(),
            param_value=as_float,
            param_type=mavlink.MAV_PARAM_TYPE_UINT32,
            param_count=len(type(values).model_fields),
            param_index=NO_INDEX,
        )
    )
