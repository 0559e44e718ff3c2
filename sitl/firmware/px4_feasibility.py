"""What PX4 refuses to fly: `FeasibilityChecker` and `MissionFeasibilityChecker` of its navigator."""

import math

from sitl.arrays import Vec3
from sitl.firmware.px4_parameters import Px4Parameters
from sitl.plan.fence import FenceError, Limits, boundary
from sitl.plan.items import Command, Item, Plan
from sitl.plan.places import GLOBAL, local_place

_ACTS_ON_BREACH = 1


def fence_limits(parameters: Px4Parameters, fence: Plan) -> Limits | None:
    """What the fence forbids; None when it forbids nothing, or GF_ACTION is none."""
    p = parameters
    if p.GF_ACTION < _ACTS_ON_BREACH:
        return None
    try:
        areas = boundary(fence.items)
    except FenceError:
        return None
    limits = Limits(p.GF_MAX_HOR_DIST or math.inf, p.GF_MAX_VER_DIST or math.inf, boundary=areas)
    free = not (areas.inclusions or areas.exclusions or p.GF_MAX_HOR_DIST or p.GF_MAX_VER_DIST)
    return None if free else limits


def reason_to_refuse(
    mission: Plan, limits: Limits | None, parameters: Px4Parameters, home: Vec3, *, landed: bool
) -> str | None:
    """Why a mission cannot be flown; None when it can."""
    items = mission.items
    if landed and items and items[0].command == Command.NAV_LAND:
        return "starts with landing"
    placed = [(n, item) for n, item in enumerate(items) if item.is_navigation and item.frame in GLOBAL]
    if placed:
        north, east, _ = (local_place(placed[0][1], home) - home).tolist()
        if 0.0 < parameters.MIS_DIST_1WP < math.hypot(north, east):
            return f"first waypoint too far away: {math.hypot(north, east):.0f} m"
    for place, (number, item) in enumerate(placed):
        reason = _takeoff_reason(place, item, home)
        if reason is None and limits and limits.broken_at(local_place(item, home), home):
            reason = f"geofence violation for waypoint {number + 1}"
        if reason:
            return reason
    return None


def _takeoff_reason(place: int, item: Item, home: Vec3) -> str | None:
    if item.command != Command.NAV_TAKEOFF:
        return None
    if place:
        return "takeoff is not the first waypoint item"
    return None if local_place(item, home)[2] < home[2] else "takeoff altitude too low"
