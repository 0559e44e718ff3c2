"""How far a plan may lead: near the vehicle, inside the guard's box, the plan's and the vehicle's fences."""

import numpy as np

from companion.arrays import Vec3
from companion.errors import InputError
from companion.flight.fence import Areas, Circle, Polygon
from companion.mission.items import Fence
from companion.mission.path import TrackedPath
from companion.mission.site import Site
from companion.trajectory import Trajectory

_LOOK_EVERY_S = 0.1
_ROUNDING_M = 1e-6


def require_near(path: TrackedPath, here: Vec3, max_distance_m: float) -> None:
    """Refuse a path that leads farther than `max_distance_m` from `here` (NED from the takeoff point, m).

    Raises:
        InputError: a waypoint is farther away; names the farthest, and says how far.
    """
    distances_m = [float(np.linalg.norm(waypoint.position - here)) for waypoint in path.waypoints]
    farthest = int(np.argmax(distances_m))
    beyond_m = distances_m[farthest] - max_distance_m
    if beyond_m > _ROUNDING_M:
        raise InputError(
            f"{path.name(farthest)} is {distances_m[farthest]:.1f} m from the vehicle, {beyond_m:.1f} m more "
            f"than max_distance_m {max_distance_m:g}: start nearer to it, or allow more (--guard FILE)"
        )


def require_inside_box(path: TrackedPath, lowest: Vec3, highest: Vec3) -> None:
    """Refuse a path that leaves the guard's fence, a box between two corners (NED from the takeoff point, m).

    Raises:
        InputError: a waypoint is outside; names the one that is farthest out, and says how far and where.
    """
    positions = np.array([waypoint.position for waypoint in path.waypoints])
    outside = np.concatenate([lowest - positions, positions - highest], axis=1)
    waypoint, side = np.unravel_index(outside.argmax(), outside.shape)
    beyond_m = outside[waypoint, side]
    if beyond_m > _ROUNDING_M:
        where = ("south", "west", "upwards", "north", "east", "downwards")[int(side)]
        key = ("north_m", "east_m", "altitude_m")[int(side) % 3]
        raise InputError(
            f"{path.name(int(waypoint))} is {beyond_m:.1f} m beyond the guard's fence, {where}: "
            f"move it, or widen {key} of the fence (--guard FILE)"
        )


def require_inside_areas(path: TrackedPath, trajectory: Trajectory, areas: Areas, whose: str) -> None:
    """Refuse a trajectory that leaves every area to stay in, or enters one to keep out of.

    Args:
        path: its waypoints, which the message names.
        trajectory: NED from the takeoff point (m).
        areas: of a fence.
        whose: fence it is, for the message: "plan" or "vehicle".

    Raises:
        InputError: it leaves the fence; names the nearest waypoint, and says how far.
    """
    looked_at_s = np.append(np.arange(0.0, trajectory.duration_s, _LOOK_EVERY_S), trajectory.duration_s)
    positions = trajectory.sample(looked_at_s).position
    beyond_m = np.array([areas.beyond_m(position[:2]) for position in positions])
    worst = int(beyond_m.argmax())
    if beyond_m[worst] > _ROUNDING_M:
        distances_m = [np.linalg.norm(waypoint.position - positions[worst]) for waypoint in path.waypoints]
        raise InputError(
            f"the way is {beyond_m[worst]:.1f} m beyond the {whose}'s fence near "
            f"{path.name(int(np.argmin(distances_m)))}: move that, or change the fence"
        )


def areas_of(fence: Fence, site: Site) -> Areas:
    """The areas of `fence` in metres north and east of the takeoff point."""

    def metres(latitude_deg: float, longitude_deg: float) -> tuple[float, float]:
        north, east = site.horizontal(latitude_deg, longitude_deg).tolist()
        return north, east

    circles = []
    for circle in fence.circles:
        north_m, east_m = metres(circle.latitude_deg, circle.longitude_deg)
        circles.append(
            Circle(radius_m=circle.radius_m, north_m=north_m, east_m=east_m, keep_out=not circle.inclusion)
        )
    polygons = [
        Polygon(
            corners_m=tuple(metres(*vertex) for vertex in polygon.vertices), keep_out=not polygon.inclusion
        )
        for polygon in fence.polygons
    ]
    return Areas(circles=tuple(circles), polygons=tuple(polygons))
