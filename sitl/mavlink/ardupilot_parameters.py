"""Parameters as ArduPilot sends them: numbers, whatever their type (its GCS_Param.cpp and AP_Param.cpp)."""

import math

from pymavlink.dialects.v20 import common as mavlink

from sitl.firmware.parameters import Stored
from sitl.mavlink.parameters import ParameterWire

_TYPES = {
    Stored.INT8: mavlink.MAV_PARAM_TYPE_INT8,
    Stored.INT16: mavlink.MAV_PARAM_TYPE_INT16,
    Stored.INT32: mavlink.MAV_PARAM_TYPE_INT32,
    Stored.FLOAT: mavlink.MAV_PARAM_TYPE_REAL32,
}
_ROUNDING = 0.01
"""Added to the size of a number that becomes a whole one."""


def _encode(stored: Stored, value: float) -> tuple[float, int]:
    return float(value), _TYPES[stored]


def _decode(stored: Stored, field: float, kind: int) -> float | None:
    """The type that a client gives does not count."""
    if stored is Stored.FLOAT or not math.isfinite(field):
        return field
    return int(field + math.copysign(_ROUNDING, field))


WIRE = ParameterWire(_encode, _decode, says_index=False)
