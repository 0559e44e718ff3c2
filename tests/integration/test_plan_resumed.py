"""A plan whose flight was taken goes on where it is nearest, when asked."""

import asyncio
from functools import partial

import numpy as np
import pytest
from tampered_link import POSCTL, Pilot, TamperedLink, connected, virtually

from companion import clock
from companion.cli.fly_plan import Planned
from companion.errors import TakenError
from companion.flight.flight import FlightPlan
from companion.geodesy import PX4_EARTH, Place, geodetic_from_ned
from companion.link.dialect import mavlink
from companion.mission.items import Frame, MissionItem, Plan
from companion.trajectory import Limits
from sitl.geodesy import HOME

SETPOINT = mavlink.MAVLink_set_position_target_local_ned_message


def item(north: float, east: float, command: int = mavlink.MAV_CMD_NAV_WAYPOINT) -> MissionItem:
    home = Place(HOME.latitude_deg, HOME.longitude_deg, HOME.altitude_m)
    place = geodetic_from_ned(np.array([north, east, 0.0]), home, PX4_EARTH)
    return MissionItem(command, Frame.ABOVE_HOME, x=place.latitude_deg, y=place.longitude_deg, z=5.0)


PLAN = Plan(
    mission=(item(0.0, 0.0, mavlink.MAV_CMD_NAV_TAKEOFF), item(0.0, 60.0), item(10.0, 60.0)),
    hover_speed_m_s=2.5,
)


async def laid(pilot: Pilot, *, resume: bool) -> FlightPlan:
    course = Planned("survey", PLAN, partial(FlightPlan, resume=resume), None, None, resume)
    return await course.lay(pilot.connection, pilot.telemetry, Limits(), lambda text: None)


def test_a_plan_goes_on_at_its_nearest_point() -> None:
    link = TamperedLink()

    async def scenario() -> None:
        async with connected(link) as pilot:

            def at(text: str) -> None:
                if text.startswith("tracking"):
                    asyncio.get_running_loop().call_later(8.0, link.pilot_switches_to, POSCTL)

            pilot.on_announce = at
            with pytest.raises(TakenError):
                await pilot.fly(await laid(pilot, resume=False))
            pilot.on_announce = lambda text: None
            await asyncio.sleep(4.0)
            east, resumed_s = link.firmware.estimate.position[1], clock.now()
            assert 10.0 < east < 50.0
            outcome = await pilot.fly(await laid(pilot, resume=True))
            assert outcome.accuracy.max_m < 2.0
            assert not outcome.clips
            places = np.array(
                [
                    (each.x, each.y, each.z)
                    for time_s, each in link.sent
                    if isinstance(each, SETPOINT) and time_s > resumed_s
                ]
            )
            assert places[:, 1].min() > east - 0.5
            np.testing.assert_allclose(places[-1], (10.0, 60.0, -5.0), atol=0.2)

    virtually(scenario())
