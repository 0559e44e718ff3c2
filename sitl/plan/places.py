"""Where items are, in the local frame: NED, metres, from the origin of the map."""

import math

import numpy as np

from sitl.arrays import Vec3
from sitl.geodesy import PX4_EARTH_M, Geodetic, ned_from_geodetic
from sitl.plan.items import Item

ABOVE_SEA = (0, 5)
"""MAV_FRAME_GLOBAL and its twin for whole numbers."""
ABOVE_HOME = (3, 6)
"""MAV_FRAME_GLOBAL_RELATIVE_ALT and its twin."""
ABOVE_TERRAIN = (10, 11)
"""MAV_FRAME_GLOBAL_TERRAIN_ALT and its twin; here the ground is as high as home everywhere."""
GLOBAL = ABOVE_SEA + ABOVE_HOME + ABOVE_TERRAIN


def local_place(item: Item, home: Vec3, earth_radius_m: float = PX4_EARTH_M) -> Vec3:
    """Where an item is, its altitude above `home` (NED, m) unless its frame is above the sea."""
    above_sea = item.frame in ABOVE_SEA
    altitude_m = item.z if above_sea else 0.0
    place = Geodetic(item.x * 1e-7, item.y * 1e-7, altitude_m)
    north, east, down = ned_from_geodetic(place, earth_radius_m)
    return np.array((north, east, down if above_sea else float(home[2]) - item.z))


def is_on_earth(item: Item) -> bool:
    """Whether latitude, longitude and altitude can be."""
    return abs(item.x) <= 900_000_000 and abs(item.y) <= 1_800_000_000 and math.isfinite(item.z)
