"""Fences: where a vehicle may be, and whether it is there.

https://mavlink.io/en/services/mission.html#geofence_plan: a polygon is as many vertices in a row as parameter
1 of each says; a circle has its radius there.
"""

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from sitl.arrays import Array, Vec3
from sitl.geodesy import PX4_EARTH_M
from sitl.plan.items import Command, Item
from sitl.plan.places import local_place

_ORIGIN = np.zeros(3)
_INCLUSIONS = (Command.FENCE_INCLUSION_VERTEX, Command.FENCE_INCLUSION_CIRCLE)
_VERTICES = (Command.FENCE_INCLUSION_VERTEX, Command.FENCE_EXCLUSION_VERTEX)
_CIRCLES = (Command.FENCE_INCLUSION_CIRCLE, Command.FENCE_EXCLUSION_CIRCLE)


@dataclass(frozen=True, slots=True)
class Circle:
    """A round area: its middle north and east, and its radius (m)."""

    north: float
    east: float
    radius: float

    def contains(self, north: float, east: float) -> bool:
        """Whether a point is inside, or on the edge."""
        return math.hypot(north - self.north, east - self.east) <= self.radius


@dataclass(frozen=True, slots=True, eq=False)
class Polygon:
    """An area between corners, north and east (m), in their order."""

    corners: Float[Array, "n 2"]

    def contains(self, north: float, east: float) -> bool:
        """Whether a point is inside: a ray from it crosses the edges an odd number of times."""
        here = self.corners
        there = np.roll(here, -1, axis=0)
        across = (here[:, 1] > east) != (there[:, 1] > east)
        span = np.where(across, there[:, 1] - here[:, 1], 1.0)
        crossing = here[:, 0] + (there[:, 0] - here[:, 0]) * (east - here[:, 1]) / span
        return bool(np.count_nonzero(across & (north < crossing)) % 2)


Area = Circle | Polygon


@dataclass(frozen=True, slots=True, eq=False)
class Boundary:
    """Where a vehicle may be: in all inclusions and in no exclusion, as both autopilots have it."""

    inclusions: tuple[Area, ...] = ()
    exclusions: tuple[Area, ...] = ()

    def allows(self, north: float, east: float) -> bool:
        """Whether a point is within."""
        included = all(area.contains(north, east) for area in self.inclusions)
        return included and not any(area.contains(north, east) for area in self.exclusions)


class FenceError(ValueError):
    """Fence items that make no areas."""


def boundary(items: tuple[Item, ...], earth_radius_m: float = PX4_EARTH_M) -> Boundary:
    """The areas that fence items stand for.

    Raises:
        FenceError: a polygon with too few or missing vertices, or a radius that is none.
    """
    areas = list(_areas(items, earth_radius_m))
    return Boundary(
        tuple(area for command, area in areas if command in _INCLUSIONS),
        tuple(area for command, area in areas if command not in _INCLUSIONS),
    )


def _areas(items: tuple[Item, ...], earth_radius_m: float) -> Iterator[tuple[int, Area]]:
    start = 0
    while start < len(items):
        item = items[start]
        if item.command in _VERTICES:
            count = round(item.param(1))
            vertices = items[start : start + count]
            alike = all((each.command, each.params[0]) == (item.command, item.params[0]) for each in vertices)
            if count < 3 or len(vertices) < count or not alike:
                raise FenceError(f"fence item {start}: a polygon of {count} vertices is not complete")
            yield (
                item.command,
                Polygon(np.array([local_place(each, _ORIGIN, earth_radius_m)[:2] for each in vertices])),
            )
            start += count
            continue
        if item.command in _CIRCLES:
            if not item.param(1) > 0.0:
                raise FenceError(f"fence item {start}: a circle needs a radius above 0")
            north, east, _ = local_place(item, _ORIGIN, earth_radius_m).tolist()
            yield item.command, Circle(north, east, item.param(1))
        start += 1


@dataclass(frozen=True, slots=True, eq=False)
class Limits:
    """What a fence forbids; an infinite limit is none.

    Attributes:
        distance: from home (m).
        height: above home (m).
        least_height: above home (m).
        boundary: the areas.
    """

    distance: float = math.inf
    height: float = math.inf
    least_height: float = -math.inf
    boundary: Boundary = Boundary()

    def broken_at(self, position: Vec3, home: Vec3) -> str:
        """The first limit that a place (NED, m) breaks: "altitude", "distance", "boundary"; "" for none."""
        north, east, down = position.tolist()
        height = float(home[2]) - down
        if not self.least_height <= height <= self.height:
            return "altitude"
        if math.hypot(north - home[0], east - home[1]) > self.distance:
            return "distance"
        return "" if self.boundary.allows(north, east) else "boundary"
