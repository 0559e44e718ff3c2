"""Between places on the Earth and metres north, east and down of one of them.

An autopilot turns GPS into local coordinates on an Earth of its own, a sphere. What it is to reach must be
turned on the same one: against WGS 84 PX4's is 0.3 % too small to the east, 3 m at a kilometre.
"""

from dataclasses import dataclass

import numpy as np
from pymap3d import Ellipsoid, geodetic2ned, ned2geodetic

from companion.arrays import Vec3

WGS84 = Ellipsoid.from_name("wgs84")
PX4_EARTH = Ellipsoid(6_371_000.0, 6_371_000.0, name="CONSTANTS_RADIUS_OF_EARTH of PX4")
ARDUPILOT_EARTH = Ellipsoid(6_378_100.0, 6_378_100.0, name="RADIUS_OF_EARTH of ArduPilot")
"""ArduPilot takes distances along the mean parallel: at 50° of latitude 9 cm from this at a kilometre."""


@dataclass(frozen=True, slots=True)
class Place:
    """A place on the Earth: latitude and longitude in degrees, altitude above mean sea level (m)."""

    latitude_deg: float
    longitude_deg: float
    altitude_m: float


def ned_from_geodetic(place: Place, origin: Place, earth: Ellipsoid = WGS84) -> Vec3:
    """Where `place` is from `origin` (NED, m); down is the difference in altitude, as autopilots have it."""
    north, east, _ = geodetic2ned(
        *(place.latitude_deg, place.longitude_deg, 0.0),
        *(origin.latitude_deg, origin.longitude_deg, 0.0),
        ell=earth,
    )
    return np.array([north, east, origin.altitude_m - place.altitude_m])


def geodetic_from_ned(position: Vec3, origin: Place, earth: Ellipsoid = WGS84) -> Place:
    """The place at `position` (NED, m) from `origin`: the inverse of `ned_from_geodetic`."""
    north, east, down = position
    latitude_deg, longitude_deg, _ = ned2geodetic(
        *(north, east, 0.0), *(origin.latitude_deg, origin.longitude_deg, 0.0), ell=earth
    )
    return Place(float(latitude_deg), float(longitude_deg), origin.altitude_m - float(down))
