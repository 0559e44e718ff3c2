"""How far a plan may lead: near the vehicle, inside the guard's box, the plan's and the vehicle's fences."""

import numpy as np
from jaxtyping import Float

from companion.arrays import Array, Vec3
from companion.errors import InputError
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


def require_inside_fence(
    path: TrackedPath, trajectory: Trajectory, fence: Fence, site: Site, whose: str
) -> None:
    """Refuse a trajectory that leaves every inclusion area of `fence`, or enters an exclusion area.

    Args:
        path: its waypoints, which the message names.
        trajectory: NED from the takeoff point (m).
        fence: where the vehicle may be.
        site: where the takeoff point is.
        whose: fence it is, for the message: "plan" or "vehicle".

    Raises:
        InputError: it leaves the fence; names the nearest waypoint, and says how far.
    """
    positions = trajectory.sample(np.arange(0.0, trajectory.duration_s, _LOOK_EVERY_S)).position
    beyond_m = beyond_fence_m(positions[:, :2], fence, site)
    worst = int(beyond_m.argmax())
    if beyond_m[worst] > _ROUNDING_M:
        distances_m = [np.linalg.norm(waypoint.position - positions[worst]) for waypoint in path.waypoints]
        raise InputError(
            f"the way is {beyond_m[worst]:.1f} m beyond the {whose}'s fence near "
            f"{path.name(int(np.argmin(distances_m)))}: move that, or change the fence"
        )


def beyond_fence_m(points: Float[Array, "n 2"], fence: Fence, site: Site) -> Float[Array, " n"]:
    """How far each point (north, east from takeoff, m) is where the vehicle must not be; negative elsewhere.

    Inside one inclusion area is enough, as PX4 has it.
    """
    areas: list[tuple[bool, Float[Array, " n"]]] = []
    for polygon in fence.polygons:
        corners = np.array([site.horizontal(*vertex) for vertex in polygon.vertices])
        areas.append((polygon.inclusion, _outside_polygon_m(points, corners)))
    for circle in fence.circles:
        offsets = points - site.horizontal(circle.latitude_deg, circle.longitude_deg)
        areas.append((circle.inclusion, np.linalg.norm(offsets, axis=1) - circle.radius_m))
    beyond_m = [
        np.full(len(points), -np.inf),
        *(-outside_m for inclusion, outside_m in areas if not inclusion),
    ]
    included = [outside_m for inclusion, outside_m in areas if inclusion]
    if included:
        beyond_m.append(np.min(included, axis=0))
    return np.asarray(np.max(beyond_m, axis=0))


def _outside_polygon_m(points: Float[Array, "n 2"], corners: Float[Array, "m 2"]) -> Float[Array, " n"]:
    """How far each point is outside of a polygon; negative inside. By the even-odd rule."""
    inside = np.zeros(len(points), dtype=bool)
    nearest_m = np.full(len(points), np.inf)
    for start, end in zip(corners, np.roll(corners, -1, axis=0), strict=True):
        along = end - start
        share = np.clip((points - start) @ along / max(float(along @ along), 1e-12), 0.0, 1.0)
        nearest_m = np.minimum(nearest_m, np.linalg.norm(points - start - share[:, None] * along, axis=1))
        crosses = (start[0] > points[:, 0]) != (end[0] > points[:, 0])
        if along[0]:
            east = start[1] + (points[:, 0] - start[0]) / along[0] * along[1]
            inside ^= crosses & (points[:, 1] < east)
    return np.where(inside, -nearest_m, nearest_m)
