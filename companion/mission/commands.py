"""The commands that a mission may hold: https://mavlink.io/en/messages/common.html#MAV_CMD."""

from companion.link.dialect import mavlink

_NAMES = {
    number: entry.name.removeprefix("MAV_CMD_")
    for number, entry in mavlink.enums["MAV_CMD"].items()
    if number != mavlink.MAV_CMD_ENUM_END
}

WAYPOINTS = frozenset({mavlink.MAV_CMD_NAV_WAYPOINT, mavlink.MAV_CMD_NAV_SPLINE_WAYPOINT})
"""Commands that mean nothing without a place."""

FLOWN_TO = WAYPOINTS | {
    mavlink.MAV_CMD_NAV_LOITER_UNLIM,
    mavlink.MAV_CMD_NAV_LOITER_TURNS,
    mavlink.MAV_CMD_NAV_LOITER_TIME,
    mavlink.MAV_CMD_NAV_LAND,
    mavlink.MAV_CMD_NAV_TAKEOFF,
    mavlink.MAV_CMD_NAV_LOITER_TO_ALT,
    mavlink.MAV_CMD_NAV_VTOL_TAKEOFF,
    mavlink.MAV_CMD_NAV_VTOL_LAND,
    mavlink.MAV_CMD_NAV_PAYLOAD_PLACE,
}
"""Commands whose place the vehicle goes to."""

LOCATED = FLOWN_TO | {
    mavlink.MAV_CMD_NAV_ROI,
    mavlink.MAV_CMD_DO_SET_HOME,
    mavlink.MAV_CMD_DO_LAND_START,
    mavlink.MAV_CMD_DO_SET_ROI_LOCATION,
    mavlink.MAV_CMD_DO_SET_ROI,
    mavlink.MAV_CMD_NAV_FENCE_RETURN_POINT,
    mavlink.MAV_CMD_NAV_FENCE_POLYGON_VERTEX_INCLUSION,
    mavlink.MAV_CMD_NAV_FENCE_POLYGON_VERTEX_EXCLUSION,
    mavlink.MAV_CMD_NAV_FENCE_CIRCLE_INCLUSION,
    mavlink.MAV_CMD_NAV_FENCE_CIRCLE_EXCLUSION,
    mavlink.MAV_CMD_NAV_RALLY_POINT,
}
"""Commands whose parameters 5 to 7 are a place."""


def is_known(command: int) -> bool:
    """Whether MAVLink knows this MAV_CMD, ArduPilot's own ones included."""
    return command in _NAMES


def command_name(command: int) -> str:
    """The name of a MAV_CMD without that prefix, such as NAV_WAYPOINT."""
    return _NAMES.get(command, f"MAV_CMD {command}")
