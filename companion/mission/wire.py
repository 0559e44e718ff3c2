"""Between plans and the items that the mission protocol carries.

ArduPilot counts home as item 0 of a mission, and takes 0 where PX4 takes NaN for "not given".
"""

import math
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass, replace

from companion.errors import FlightError, InputError
from companion.geodesy import Place
from companion.link.dialect import mavlink
from companion.link.mission import WireItem
from companion.mission.commands import LOCATED, command_name
from companion.mission.items import (
    Fence,
    FenceCircle,
    FencePolygon,
    Frame,
    MissionItem,
    frame_from_number,
    naming,
)

_DEGREES = 1e7
"""Latitudes and longitudes are sent as integers, in units of 1e-7 degrees."""
_SAME_PLACE = 10
"""Apart at most, in those units: 0.1 m."""
_SAME_ALTITUDE_M = 0.05
_POLYGONS = {
    mavlink.MAV_CMD_NAV_FENCE_POLYGON_VERTEX_INCLUSION: True,
    mavlink.MAV_CMD_NAV_FENCE_POLYGON_VERTEX_EXCLUSION: False,
}
_CIRCLES = {
    mavlink.MAV_CMD_NAV_FENCE_CIRCLE_INCLUSION: True,
    mavlink.MAV_CMD_NAV_FENCE_CIRCLE_EXCLUSION: False,
}


@dataclass(frozen=True, slots=True)
class Dialect:
    """How an autopilot has its items.

    Attributes:
        home_first: whether item 0 of a mission is home.
        not_given: what it takes for a number that is not given.
    """

    home_first: bool
    not_given: float


PX4 = Dialect(home_first=False, not_given=math.nan)
ARDUPILOT = Dialect(home_first=True, not_given=0.0)


def mission_to_wire(mission: Sequence[MissionItem], home: Place | None, dialect: Dialect) -> list[WireItem]:
    """The items of a mission as they are sent.

    Args:
        mission: the items.
        home: of the vehicle; PX4 takes off at it where a takeoff names no place.
        dialect: of the vehicle.

    Raises:
        InputError: an item needs a place, and home is not known either.
    """
    if not dialect.home_first:
        return [item_to_wire(_placed(item, index, home), dialect) for index, item in enumerate(mission)]
    at = home or Place(0.0, 0.0, 0.0)
    first = MissionItem(
        mavlink.MAV_CMD_NAV_WAYPOINT, Frame.GLOBAL, x=at.latitude_deg, y=at.longitude_deg, z=at.altitude_m
    )
    return [item_to_wire(first, dialect), *(item_to_wire(item.jumping(1), dialect) for item in mission)]


def mission_from_wire(items: Sequence[WireItem], dialect: Dialect) -> tuple[MissionItem, ...]:
    """The mission in what a vehicle sent.

    Raises:
        FlightError: it sent an item that is none.
    """
    skipped = 1 if dialect.home_first else 0
    mission = [_item_from_wire(item, index) for index, item in enumerate(items)][skipped:]
    return tuple(item.jumping(-skipped) for item in mission)


def fence_to_wire(fence: Fence) -> list[WireItem]:
    """The items of a fence as they are sent."""
    items = [
        MissionItem(
            _command(_POLYGONS, polygon.inclusion),
            Frame.GLOBAL,
            (float(len(polygon.vertices)), 0.0, 0.0, 0.0),
            *vertex,
        )
        for polygon in fence.polygons
        for vertex in polygon.vertices
    ]
    items += [
        MissionItem(
            _command(_CIRCLES, circle.inclusion),
            Frame.GLOBAL,
            (circle.radius_m, 0.0, 0.0, 0.0),
            circle.latitude_deg,
            circle.longitude_deg,
        )
        for circle in fence.circles
    ]
    if fence.breach_return is not None:
        items.append(_point(mavlink.MAV_CMD_NAV_FENCE_RETURN_POINT, fence.breach_return))
    return [item_to_wire(item, PX4) for item in items]


def fence_from_wire(items: Sequence[WireItem]) -> Fence:
    """The fence in what a vehicle sent.

    Raises:
        FlightError: it sent what is no fence.
    """
    polygons, circles, breach_return = [], [], None
    corners: list[tuple[float, float]] = []
    for index, wire in enumerate(items):
        item = _item_from_wire(wire, index)
        at = item.x or 0.0, item.y or 0.0
        if item.command in _POLYGONS:
            corners.append(at)
            if len(corners) >= wire.param1:
                polygons.append((tuple(corners), _POLYGONS[item.command]))
                corners = []
        elif item.command in _CIRCLES:
            circles.append((*at, wire.param1, _CIRCLES[item.command]))
        elif item.command == mavlink.MAV_CMD_NAV_FENCE_RETURN_POINT:
            breach_return = Place(*at, wire.z)
        else:
            raise FlightError(f"the vehicle's fence holds {item.name}, which is none of a fence")
    try:
        return Fence(
            tuple(FencePolygon(*polygon) for polygon in polygons),
            tuple(FenceCircle(*circle) for circle in circles),
            breach_return,
        )
    except InputError as error:
        raise FlightError(f"the vehicle's fence: {error}") from error


def rally_to_wire(rally: Sequence[Place]) -> list[WireItem]:
    """Rally points as they are sent; their altitudes are above home."""
    return [item_to_wire(_point(mavlink.MAV_CMD_NAV_RALLY_POINT, place), PX4) for place in rally]


def rally_from_wire(items: Sequence[WireItem]) -> tuple[Place, ...]:
    """The rally points in what a vehicle sent."""
    return tuple(Place(item.x / _DEGREES, item.y / _DEGREES, item.z) for item in items)


def item_to_wire(item: MissionItem, dialect: Dialect) -> WireItem:
    """One item as it is sent.

    A command without a place goes in the frame for those, whatever the file said: PX4 refuses others.
    """
    scale = _DEGREES if item.has_place else 1.0
    p1, p2, p3, p4, z = (dialect.not_given if value is None else value for value in (*item.params, item.z))
    return WireItem(
        frame=int(item.frame if item.command in LOCATED else Frame.NONE),
        command=item.command,
        autocontinue=int(item.autocontinue),
        param1=p1,
        param2=p2,
        param3=p3,
        param4=p4,
        x=round((item.x or 0.0) * scale),
        y=round((item.y or 0.0) * scale),
        z=z,
    )


def difference(sent: Sequence[WireItem], kept: Sequence[WireItem], first: int = 0) -> str | None:
    """What a vehicle keeps otherwise than it was sent, in words; None where it is the same.

    Compared are the commands, places and targets of jumps, from item `first` on: autopilots store other
    parameters only as far as they use them.
    """
    if len(sent) != len(kept):
        return f"it keeps {len(kept)} items of {len(sent)}"
    for index, (ours, theirs) in enumerate(zip(sent, kept, strict=True)):
        if index >= first and not _same(ours, theirs):
            return f"it keeps item {index} as {_shown(theirs)} instead of {_shown(ours)}"
    return None


def _same(ours: WireItem, theirs: WireItem) -> bool:
    if ours.command != theirs.command:
        return False
    if ours.command == mavlink.MAV_CMD_DO_JUMP:
        return ours.param1 == theirs.param1
    if ours.command not in LOCATED or ours.frame == Frame.NONE:
        return True
    apart = max(abs(ours.x - theirs.x), abs(ours.y - theirs.y))
    higher_m = abs(ours.z - theirs.z)
    if apart > _SAME_PLACE or higher_m > _SAME_ALTITUDE_M:  # what was not given, NaN, is not compared
        return False
    with suppress(InputError):
        return frame_from_number(ours.frame) is frame_from_number(theirs.frame)
    return False


def _shown(item: WireItem) -> str:
    place = f" at {item.x / _DEGREES:.7f}, {item.y / _DEGREES:.7f}, {item.z:g} m in frame {item.frame}"
    return command_name(item.command) + (place if item.command in LOCATED else f" {item.param1:g}")


def _item_from_wire(item: WireItem, index: int) -> MissionItem:
    try:
        with naming(f"the vehicle's item {index}"):
            frame = frame_from_number(item.frame)
            scale = _DEGREES if item.command in LOCATED and frame is not Frame.NONE else 1.0
            p1, p2, p3, p4, z = (
                None if math.isnan(value) else value
                for value in (item.param1, item.param2, item.param3, item.param4, item.z)
            )
            return MissionItem(
                item.command,
                frame,
                (p1, p2, p3, p4),
                item.x / scale,
                item.y / scale,
                z,
                autocontinue=bool(item.autocontinue),
            )
    except InputError as error:
        raise FlightError(str(error)) from error


def _placed(item: MissionItem, index: int, home: Place | None) -> MissionItem:
    """The item, at home if it is a takeoff that names no place."""
    if item.command != mavlink.MAV_CMD_NAV_TAKEOFF or item.coordinates is not None:
        return item
    if home is None:
        raise InputError(f"item {index}: NAV_TAKEOFF names no place, and the vehicle tells no home")
    return replace(item, x=home.latitude_deg, y=home.longitude_deg)


def _command(kinds: dict[int, bool], inclusion: bool) -> int:
    return next(command for command, is_inclusion in kinds.items() if is_inclusion is inclusion)


def _point(command: int, place: Place) -> MissionItem:
    return MissionItem(
        command, Frame.ABOVE_HOME, x=place.latitude_deg, y=place.longitude_deg, z=place.altitude_m
    )
