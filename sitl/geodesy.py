"""Geodetic and local coordinates around home, on a flat earth.

Small offsets on a sphere: north = R Δlat, east = R cos(lat0) Δlon. PX4 and ArduPilot differ in R; a client
that computes as the autopilot does agrees to millimetres (PX4) or centimetres within a kilometre of home.
"""

import math
from dataclasses import dataclass

PX4_EARTH_M = 6_371_000.0
"""CONSTANTS_RADIUS_OF_EARTH in PX4's geo library."""
ARDUPILOT_EARTH_M = 6_378_100.0
"""RADIUS_OF_EARTH in ArduPilot's AP_Math, the same as its LATLON_TO_M."""


@dataclass(frozen=True, slots=True)
class Geodetic:
    """Latitude and longitude (degrees, WGS 84), altitude above mean sea level (m)."""

    latitude_deg: float
    longitude_deg: float
    altitude_m: float


HOME = Geodetic(47.397742, 8.545594, 488.0)
"""Where the simulated vehicle starts, PX4's default home of its simulators: the origin of the local frame."""

_HOME_PARALLEL = math.cos(math.radians(HOME.latitude_deg))
"""The radius of the parallel through home over that of the earth."""


def geodetic_from_ned(
    north: float, east: float, down: float, earth_radius_m: float = PX4_EARTH_M
) -> Geodetic:
    """The place at a local position (m from home)."""
    metres_per_degree = math.radians(earth_radius_m)
    return Geodetic(
        HOME.latitude_deg + north / metres_per_degree,
        HOME.longitude_deg + east / (metres_per_degree * _HOME_PARALLEL),
        HOME.altitude_m - down,
    )


def ned_from_geodetic(place: Geodetic, earth_radius_m: float = PX4_EARTH_M) -> tuple[float, float, float]:
    """The local position (north, east, down: m from home) of a place; a coordinate that is NaN stays so."""
    metres_per_degree = math.radians(earth_radius_m)
    return (
        (place.latitude_deg - HOME.latitude_deg) * metres_per_degree,
        (place.longitude_deg - HOME.longitude_deg) * metres_per_degree * _HOME_PARALLEL,
        HOME.altitude_m - place.altitude_m,
    )
