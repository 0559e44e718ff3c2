"""Where items are, in the local frame: NED, metres, from the origin of the map."""

import math

import numpy as np

from sitl.arrays import Vec3
from sitl.geodesy import PX4_EARTH_M, Geodetic, ned_from_geodetic
from sitl.plan.items import Command, Item

ABOVE_SEA = (0, 5)
"""MAV_FRAME_GLOBAL and its twin for whole numbers."""
ABOVE_HOME = (3, 6)
"""MAV_FRAME_GLOBAL_RELATIVE_ALT and its twin."""
ABOVE_TERRAIN = (10, 11)
"""MAV_FRAME_GLOBAL_TERRAIN_ALT and its twin; here the ground is as high as home everywhere."""
GLOBAL = ABOVE_SEA + ABOVE_HOME + ABOVE_TERRAIN
_CLOSE_M = 2.0


def local_place(item: Item, home: Vec3, earth_radius_m: float = PX4_EARTH_M) -> Vec3:
    """Where an item is, its altitude above `home` (NED, m) unless its frame is above the sea."""
    above_sea = item.frame in ABOVE_SEA
    altitude_m = item.z if above_sea else 0.0
    place = Geodetic(item.x * 1e-7, item.y * 1e-7, altitude_m)
    north, east, down = ned_from_geodetic(place, earth_radius_m)
    return np.array((north, east, down if above_sea else float(home[2]) - item.z))


def looked_at(item: Item, home: Vec3, earth_radius_m: float = PX4_EARTH_M) -> Vec3 | None:
    """The place at which an item has the vehicle look, NED (m); None when it takes that back."""
    if item.command == Command.DO_SET_ROI_NONE or item.x == item.y == 0:
        return None
    return local_place(item, home, earth_radius_m)


def bearing(here: Vec3, there: Vec3) -> float:
    """The heading from one place to another (rad); NaN where they are too close to tell."""
    north, east = there[0] - here[0], there[1] - here[1]
    return math.atan2(east, north) if math.hypot(north, east) > _CLOSE_M else math.nan


def is_on_earth(item: Item) -> bool:
    """Whether latitude, longitude and altitude can be."""
    return abs(item.x) <= 900_000_000 and abs(item.y) <= 1_800_000_000 and math.isfinite(item.z)
