"""What the parameters of a vehicle say of its fence.

PX4: https://docs.px4.io/main/en/advanced_config/parameter_reference.html (GF_), `geofence.cpp`. To reach a
limit is a breach of it, and there is no margin.

ArduPilot: https://ardupilot.org/copter/docs/parameters.html (FENCE_), `AC_Fence.cpp`. GUIDED refuses
setpoints beyond a limit; autopilots should stay FENCE_MARGIN away. The floor counts once it was passed.
"""

import math
from collections.abc import Mapping
from enum import IntFlag
from typing import TypeAlias

from companion.flight.takeoff import Announce
from companion.flight.vehicle_fence import Bound, Bounds
from companion.link.connection import Connection
from companion.link.dialect import mavlink
from companion.link.parameter import read_parameters
from companion.link.parameter_encoding import Number, usual_encoding

Values: TypeAlias = Mapping[str, Number]

_ATTEMPTS = 3
_PX4_MARGIN_M = 0.5
"""More than a vehicle that tracks well is off."""
_ALWAYS: Mapping[int, tuple[str, ...]] = {
    mavlink.MAV_AUTOPILOT_PX4: ("GF_ACTION", "GF_MAX_HOR_DIST", "GF_MAX_VER_DIST"),
    mavlink.MAV_AUTOPILOT_ARDUPILOTMEGA: (
        *("FENCE_ENABLE", "FENCE_TYPE", "FENCE_MARGIN"),
        *("FENCE_ALT_MAX", "FENCE_ALT_MIN", "FENCE_RADIUS"),
    ),
}
_SINCE_4_6 = ("FENCE_AUTOENABLE", "FENCE_OPTIONS")
"""ArduPilot Copters before have neither."""


class _Kind(IntFlag):
    """Bits of FENCE_TYPE."""

    CEILING = 1
    DISTANCE = 2
    FLOOR = 8


_NO_ACTION = 0
"""GF_ACTION."""
_ANY_INCLUSION = 1 << 1
"""FENCE_OPTIONS: allow union of inclusion areas."""


async def fence_parameters(connection: Connection, announce: Announce) -> dict[str, Number]:
    """Those that the vehicle tells, all asked for at once; announces what it should tell and does not."""
    autopilot = connection.heartbeat.autopilot
    always = _ALWAYS.get(autopilot, ())
    names = always + (_SINCE_4_6 if autopilot == mavlink.MAV_AUTOPILOT_ARDUPILOTMEGA else ())
    told = await read_parameters(connection, names, usual_encoding(autopilot), attempts=_ATTEMPTS)
    values = {name: parameter.value for name, parameter in told.items() if math.isfinite(parameter.value)}
    if silent := [name for name in always if name not in values]:
        announce(f"the vehicle does not tell {', '.join(silent)}: what they limit is not kept to")
    return values


def bounds_of(values: Values) -> Bounds:
    """How far a PX4 (GF_) or an ArduPilot (FENCE_) may go by them; what is not told bounds nothing."""
    return _ardupilot_bounds(values) if "FENCE_TYPE" in values else _px4_bounds(values)


def counts_all(values: Values) -> bool:
    """Whether the vehicle must be in all of its areas to stay in, rather than in one."""
    return not int(values.get("FENCE_OPTIONS", 0)) & _ANY_INCLUSION


def _px4_bounds(values: Values) -> Bounds:
    if values.get("GF_ACTION") == _NO_ACTION:
        return Bounds()

    def bound(parameter: str) -> Bound | None:
        value_m = values.get(parameter, 0.0)
        return Bound(parameter=parameter, value_m=value_m, margin_m=_PX4_MARGIN_M) if value_m > 0.0 else None

    return Bounds(distance=bound("GF_MAX_HOR_DIST"), ceiling=bound("GF_MAX_VER_DIST"))


def _ardupilot_bounds(values: Values) -> Bounds:
    if not (values.get("FENCE_ENABLE", 1) or values.get("FENCE_AUTOENABLE", 0)):
        return Bounds()
    kinds = int(values.get("FENCE_TYPE", 0))
    margin_m = max(values.get("FENCE_MARGIN", 0.0), 0.0)

    def bound(kind: _Kind, parameter: str) -> Bound | None:
        if not kinds & kind or parameter not in values:
            return None
        return Bound(parameter=parameter, value_m=values[parameter], margin_m=margin_m)

    return Bounds(
        distance=bound(_Kind.DISTANCE, "FENCE_RADIUS"),
        ceiling=bound(_Kind.CEILING, "FENCE_ALT_MAX"),
        floor=bound(_Kind.FLOOR, "FENCE_ALT_MIN"),
    )
