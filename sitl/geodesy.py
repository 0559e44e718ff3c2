"""Geodetic and local coordinates around home, on a flat earth.

Small offsets on a sphere: north = R Δlat, east = R cos(lat0) Δlon, with PX4's radius R = 6371000 m
(CONSTANTS_RADIUS_OF_EARTH in PX4's geo library), so that a client that computes as PX4 does agrees to
millimetres within a kilometre of home.
"""

import math
from dataclasses import dataclass

EARTH_RADIUS_M = 6_371_000.0


@dataclass(frozen=True, slots=True)
class Geodetic:
    """Latitude and longitude (degrees, WGS 84), altitude above mean sea level (m)."""

    latitude_deg: float
    longitude_deg: float
    altitude_m: float


HOME = Geodetic(47.397742, 8.545594, 488.0)
"""Where the simulated vehicle starts, PX4's default home of its simulators: the origin of the local frame."""

_METRES_PER_DEGREE_NORTH = math.radians(1.0) * EARTH_RADIUS_M
_METRES_PER_DEGREE_EAST = _METRES_PER_DEGREE_NORTH * math.cos(math.radians(HOME.latitude_deg))


def geodetic_from_ned(north: float, east: float, down: float) -> Geodetic:
    """The place at a local position (m from home)."""
    return Geodetic(
        HOME.latitude_deg + north / _METRES_PER_DEGREE_NORTH,
        HOME.longitude_deg + east / _METRES_PER_DEGREE_EAST,
        HOME.altitude_m - down,
    )


def ned_from_geodetic(place: Geodetic) -> tuple[float, float, float]:
    """The local position (north, east, down: m from home) of a place; a coordinate that is NaN stays so."""
    return (
        (place.latitude_deg - HOME.latitude_deg) * _METRES_PER_DEGREE_NORTH,
        (place.longitude_deg - HOME.longitude_deg) * _METRES_PER_DEGREE_EAST,
        HOME.altitude_m - place.altitude_m,
    )
