"""Where simulated vehicles say that they are, in virtual time and through the bytes."""

import asyncio
from typing import Any

import numpy as np
import pytest

from companion import clock
from companion.autopilot import detect
from companion.errors import NoReplyError
from companion.geodesy import ARDUPILOT_EARTH, PX4_EARTH, Place, geodetic_from_ned, ned_from_geodetic
from companion.link import Telemetry, connect, start_telemetry
from companion.link.command import request_message
from companion.link.connection import Connection
from companion.link.dialect import mavlink
from companion.mission.site import Site, vehicle_site
from sitl.geodesy import HOME


async def climbed(connection: Connection, telemetry: Telemetry) -> None:
    autopilot = await detect(connection, telemetry)
    await telemetry.next_state()
    await autopilot.arm()
    await autopilot.takeoff(3.0)


def site_of(url: str, *, airborne: bool = False) -> Site:
    async def scenario() -> Site:
        async with connect(url) as connection:
            telemetry = await start_telemetry(connection)
            if airborne:
                await climbed(connection, telemetry)
            return await vehicle_site(connection, telemetry)

    return clock.run(scenario(), virtual=True)


def is_home(origin: Place) -> bool:
    home = Place(HOME.latitude_deg, HOME.longitude_deg, HOME.altitude_m)
    return float(np.linalg.norm(ned_from_geodetic(origin, home))) < 0.1


def test_on_the_ground() -> None:
    site = site_of("sitl://bebop2")
    assert is_home(site.origin)
    assert site.earth is PX4_EARTH
    assert site.airborne is None
    assert site.takeoff == pytest.approx(np.zeros(3), abs=0.05)


def test_ardupilots_earth_is_another() -> None:
    site = site_of("sitl://arducopter_sitl")
    assert is_home(site.origin)
    assert site.earth is ARDUPILOT_EARTH


def test_in_the_air_a_path_begins_where_the_vehicle_is() -> None:
    site = site_of("sitl://bebop2", airborne=True)
    assert site.airborne is not None
    assert site.start(9.0) == pytest.approx([0.0, 0.0, -3.0], abs=0.4)


def test_an_origin_that_is_not_told_is_derived(monkeypatch: pytest.MonkeyPatch) -> None:
    async def silent_about_its_origin(connection: Connection, kind: Any) -> Any:
        if kind is mavlink.MAVLink_gps_global_origin_message:
            raise NoReplyError("not told")
        await asyncio.sleep(0.05)
        return await request_message(connection, kind)

    monkeypatch.setattr("companion.mission.site.request_message", silent_about_its_origin)
    assert is_home(site_of("sitl://bebop2", airborne=True).origin)


def test_places_count_from_takeoff() -> None:
    origin = Place(HOME.latitude_deg, HOME.longitude_deg, HOME.altitude_m)
    site = Site(origin, PX4_EARTH, np.array([2.0, -1.0, -0.5]))
    place = geodetic_from_ned(np.array([12.0, 4.0, 0.0]), origin, PX4_EARTH)
    assert site.horizontal(place.latitude_deg, place.longitude_deg) == pytest.approx([10.0, 5.0], abs=1e-3)
    assert site.down(HOME.altitude_m + 20.0) == pytest.approx(-19.5)
    assert site.start(7.0) == pytest.approx([0.0, 0.0, -7.0])
