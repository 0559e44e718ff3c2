"""Plan items that several tests use, placed by local coordinates."""

import math

from pymavlink.dialects.v20 import common as mavlink

from sitl.geodesy import geodetic_from_ned
from sitl.plan.items import Item

_NO_PARAMS = (0.0, 0.0, 0.0, math.nan)
RELATIVE = mavlink.MAV_FRAME_GLOBAL_RELATIVE_ALT_INT
NO_FRAME = mavlink.MAV_FRAME_MISSION


def item(
    command: int,
    north: float = 0.0,
    east: float = 0.0,
    up: float = 0.0,
    params: tuple[float, float, float, float] = _NO_PARAMS,
    frame: int = RELATIVE,
) -> Item:
    """An item at a place, its altitude above home."""
    place = geodetic_from_ned(north, east, 0.0)
    x, y = round(place.latitude_deg * 1e7), round(place.longitude_deg * 1e7)
    return Item(command, frame, params, x, y, up)


def command(number: int, *params: float) -> Item:
    """An item without a place."""
    first, second, third, fourth = [*params, *[0.0] * (4 - len(params))]
    return Item(number, NO_FRAME, (first, second, third, fourth))


HOME = item(mavlink.MAV_CMD_NAV_WAYPOINT, frame=mavlink.MAV_FRAME_GLOBAL)
"""Item 0 of ArduPilot's missions."""
