import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from pymap3d import Ellipsoid

from companion.geodesy import (
    ARDUPILOT_EARTH,
    PX4_EARTH,
    WGS84,
    Place,
    geodetic_from_ned,
    ned_from_geodetic,
)

ZURICH = Place(47.397742, 8.545594, 488.0)
METRES = st.floats(-3000.0, 3000.0)


@given(
    north=METRES,
    east=METRES,
    down=METRES,
    latitude_deg=st.floats(-70.0, 70.0),
    longitude_deg=st.floats(-180.0, 180.0),
    earth=st.sampled_from([WGS84, PX4_EARTH, ARDUPILOT_EARTH]),
)
def test_there_and_back(
    north: float, east: float, down: float, latitude_deg: float, longitude_deg: float, earth: Ellipsoid
) -> None:
    origin = Place(latitude_deg, longitude_deg, 100.0)
    position = np.array([north, east, down])
    place = geodetic_from_ned(position, origin, earth)
    assert ned_from_geodetic(place, origin, earth) == pytest.approx(position, abs=0.005)


def test_known_distances() -> None:
    """A minute of latitude on WGS 84 at 45° is 1852.2 m (NGA); on PX4's sphere 1853.25 m anywhere."""
    origin = Place(45.0, 7.0, 0.0)
    north = Place(45.0 + 1.0 / 60.0, 7.0, 0.0)
    assert ned_from_geodetic(north, origin)[0] == pytest.approx(1852.2, abs=0.3)
    assert ned_from_geodetic(north, origin, PX4_EARTH)[0] == pytest.approx(6_371_000.0 * math.pi / 10_800.0)


def test_altitudes_are_differences_however_far_away() -> None:
    far = Place(47.5, 8.7, 500.0)
    assert ned_from_geodetic(far, ZURICH)[2] == pytest.approx(-12.0)


def test_east_across_the_antimeridian() -> None:
    position = ned_from_geodetic(Place(0.0, -179.999, 0.0), Place(0.0, 179.999, 0.0))
    assert position[1] == pytest.approx(222.6, abs=0.1)


def test_px4s_own_projection() -> None:
    """PX4's map_projection (azimuthal equidistant), worked out here from its definition."""
    place = Place(47.41, 8.57, 488.0)
    latitude, longitude, latitude0, longitude0 = np.radians(
        [place.latitude_deg, place.longitude_deg, ZURICH.latitude_deg, ZURICH.longitude_deg]
    )
    angle = math.acos(
        math.sin(latitude0) * math.sin(latitude)
        + math.cos(latitude0) * math.cos(latitude) * math.cos(longitude - longitude0)
    )
    scale = 6_371_000.0 * angle / math.sin(angle)
    north = scale * (
        math.cos(latitude0) * math.sin(latitude)
        - math.sin(latitude0) * math.cos(latitude) * math.cos(longitude - longitude0)
    )
    east = scale * math.cos(latitude) * math.sin(longitude - longitude0)
    assert ned_from_geodetic(place, ZURICH, PX4_EARTH) == pytest.approx([north, east, 0.0], abs=0.002)


def test_ardupilots_own_distances() -> None:
    """Location::get_distance_NE, worked out here from its definition, at a kilometre."""
    place = Place(47.4034, 8.5548, 488.0)
    metres = 6_378_100.0 * math.pi / 180.0
    north = (place.latitude_deg - ZURICH.latitude_deg) * metres
    mean = math.radians(0.5 * (place.latitude_deg + ZURICH.latitude_deg))
    east = (place.longitude_deg - ZURICH.longitude_deg) * metres * math.cos(mean)
    assert ned_from_geodetic(place, ZURICH, ARDUPILOT_EARTH) == pytest.approx([north, east, 0.0], abs=0.1)
