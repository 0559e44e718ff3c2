"""Where a vehicle is on the Earth, and where its local coordinates begin: as it says, or as planned."""

from collections import deque
from dataclasses import astuple, dataclass

import numpy as np
from pymap3d import Ellipsoid

from companion.arrays import Vec3
from companion.errors import InputError, NoReplyError
from companion.flight.takeoff import home_of
from companion.geodesy import (
    ARDUPILOT_EARTH,
    PX4_EARTH,
    WGS84,
    Place,
    geodetic_from_ned,
    ned_from_geodetic,
)
from companion.link.command import request_message
from companion.link.connection import Connection
from companion.link.dialect import mavlink
from companion.link.telemetry import Telemetry
from companion.mission.items import Plan

_EARTHS = {mavlink.MAV_AUTOPILOT_PX4: PX4_EARTH, mavlink.MAV_AUTOPILOT_ARDUPILOTMEGA: ARDUPILOT_EARTH}
_READY_WITHIN_S = 60.0
_TELLS_WITHIN_S = 3.0
_SAMPLES = 10
_SAME_INSTANT_MS = 50
_POSITIONS_KEPT = 50


@dataclass(frozen=True, slots=True, eq=False)
class Site:
    """Where a flight takes place.

    Attributes:
        origin: where the vehicle's local coordinates have their zero.
        earth: the Earth on which the vehicle works them out.
        takeoff: where it takes off or took off (NED of the origin, m).
        airborne: where it is (NED of the origin, m) if it flies already, else None.
    """

    origin: Place
    earth: Ellipsoid
    takeoff: Vec3
    airborne: Vec3 | None = None

    def horizontal(self, latitude_deg: float, longitude_deg: float) -> Vec3:
        """North and east of the takeoff point (m)."""
        place = Place(latitude_deg, longitude_deg, self.origin.altitude_m)
        return np.asarray((ned_from_geodetic(place, self.origin, self.earth) - self.takeoff)[:2])

    def down(self, above_sea_m: float) -> float:
        """Down of the takeoff point (m) of an altitude above mean sea level (m)."""
        return self.origin.altitude_m - above_sea_m - float(self.takeoff[2])

    def start(self, altitude_m: float) -> Vec3:
        """Where a path begins (NED from the takeoff point, m): here, or where a takeoff leads."""
        if self.airborne is None:
            return np.array([0.0, 0.0, -altitude_m])
        return np.asarray(self.airborne - self.takeoff)


def planned_site(plan: Plan) -> Site:
    """On the ground at the plan's own home, for looking at it without a vehicle.

    Raises:
        InputError: it has none.
    """
    if plan.home is None:
        raise InputError(
            "the plan has no planned home position: set one, or connect to the vehicle (--connect)"
        )
    return Site(plan.home, _EARTHS.get(plan.firmware, WGS84), np.zeros(3))


async def vehicle_site(connection: Connection, telemetry: Telemetry) -> Site:
    """Where the connection's vehicle is; waits until it knows.

    Raises:
        LinkError: it tells no position, no origin, or not whether it flies.
    """
    state = await telemetry.next_state(_READY_WITHIN_S)
    earth = _EARTHS.get(connection.heartbeat.autopilot, WGS84)
    origin = await _local_origin(connection, earth)
    landed = await connection.receive(
        mavlink.MAVLink_extended_sys_state_message,
        lambda told: told.landed_state != mavlink.MAV_LANDED_STATE_UNDEFINED,
        timeout_s=_TELLS_WITHIN_S,
    )
    if landed.landed_state == mavlink.MAV_LANDED_STATE_ON_GROUND:
        return Site(origin, earth, state.position)
    return Site(origin, earth, await home_of(telemetry, lambda text: None), state.position)


async def _local_origin(connection: Connection, earth: Ellipsoid) -> Place:
    """Where the vehicle's local coordinates have their zero: as it says, or from where it is in both."""
    try:
        told = await request_message(connection, mavlink.MAVLink_gps_global_origin_message)
    except NoReplyError:
        return await _derived_origin(connection, earth)
    return Place(told.latitude * 1e-7, told.longitude * 1e-7, told.altitude * 1e-3)


async def _derived_origin(connection: Connection, earth: Ellipsoid) -> Place:
    """The mean of several origins, each from a place and a local position of the same instant."""
    positions: deque[mavlink.MAVLink_local_position_ned_message] = deque(maxlen=_POSITIONS_KEPT)
    unsubscribe = connection.subscribe(mavlink.MAVLink_local_position_ned_message, positions.append)
    origins = []
    try:
        for _ in range(_SAMPLES):
            there = await request_message(connection, mavlink.MAVLink_global_position_int_message)
            apart_ms, local = min(
                ((abs(local.time_boot_ms - there.time_boot_ms), local) for local in positions),
                key=lambda pair: pair[0],
                default=(_SAME_INSTANT_MS, None),
            )
            if local is not None and apart_ms < _SAME_INSTANT_MS:
                place = Place(there.lat * 1e-7, there.lon * 1e-7, there.alt * 1e-3)
                origins.append(geodetic_from_ned(-np.array([local.x, local.y, local.z]), place, earth))
    finally:
        unsubscribe()
    if not origins:
        raise NoReplyError("the vehicle tells no place of its local origin, and none can be derived")
    return Place(*np.mean([astuple(origin) for origin in origins], axis=0).tolist())
