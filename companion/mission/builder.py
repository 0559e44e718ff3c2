"""A mission built step by step, in metres from home or by latitude and longitude."""

import math
from dataclasses import dataclass, replace

import numpy as np
from pymap3d import Ellipsoid

from companion.errors import InputError
from companion.geodesy import WGS84, Place, geodetic_from_ned
from companion.link.dialect import mavlink
from companion.mission.items import Frame, MissionItem, Parameters, Plan

_LEAST_POINTS = 3


@dataclass(frozen=True, slots=True)
class Step:
    """One item, whose place is in metres from home where it has an `offset`.

    Attributes:
        item: the command; its altitude is above home.
        offset: metres north and east of home, where the place of the item is.
    """

    item: MissionItem
    offset: tuple[float, float] | None = None

    def at(self, home: Place, earth: Ellipsoid = WGS84) -> MissionItem:
        """The item with its place on the earth, which is the one that the vehicle believes in."""
        if self.offset is None:
            return self.item
        place = geodetic_from_ned(np.array([*self.offset, 0.0]), home, earth)
        return replace(self.item, x=place.latitude_deg, y=place.longitude_deg)


@dataclass(frozen=True, slots=True)
class Mission:
    """What a vehicle is to do, one step after another. Each method gives a new mission with more steps.

    Altitudes are metres above home, distances metres north and east of home, headings degrees clockwise from
    north; a heading that is None is left to the autopilot.

    Example:
        >>> mission = Mission().takeoff(5).go(10, 0, 5).go(10, 10, 8, hold_s=2).return_home()
        >>> [step.item.name for step in mission.steps]
        ['NAV_TAKEOFF', 'NAV_WAYPOINT', 'NAV_WAYPOINT', 'NAV_RETURN_TO_LAUNCH']
    """

    steps: tuple[Step, ...] = ()

    def __len__(self) -> int:
        return len(self.steps)

    def items(self, home: Place, earth: Ellipsoid = WGS84) -> tuple[MissionItem, ...]:
        """The items for a vehicle at `home`, metres turned into degrees on `earth`."""
        return tuple(step.at(home, earth) for step in self.steps)

    def plan(self, home: Place, earth: Ellipsoid = WGS84) -> Plan:
        """The same as a plan, to be written to a file or checked.

        Raises:
            InputError: a jump goes to a step that is not there.
        """
        return Plan(self.items(home, earth), home=home)

    def takeoff(self, altitude_m: float) -> "Mission":
        """Climb to `altitude_m` above home; the first step of every flight from the ground."""
        if not altitude_m > 0.0:
            raise InputError(f"a takeoff needs a positive altitude (m), not {altitude_m:g}")
        takeoff = MissionItem(
            mavlink.MAV_CMD_NAV_TAKEOFF, Frame.ABOVE_HOME, (0.0, 0.0, 0.0, None), z=float(altitude_m)
        )
        return self._then(Step(takeoff, (0.0, 0.0)))

    def go(
        self,
        north_m: float,
        east_m: float,
        altitude_m: float,
        *,
        hold_s: float = 0.0,
        within_m: float = 0.0,
        heading_deg: float | None = None,
    ) -> "Mission":
        """Go to a place in metres from home.

        Args:
            north_m: from home.
            east_m: from home.
            altitude_m: above home.
            hold_s: how long to stay there.
            within_m: how near counts as there; 0 for as near as the autopilot usually goes.
            heading_deg: where to look on arrival.
        """
        item = _waypoint(altitude_m, hold_s, within_m, heading_deg)
        return self._then(Step(item, (float(north_m), float(east_m))))

    def waypoint(
        self,
        latitude_deg: float,
        longitude_deg: float,
        altitude_m: float,
        *,
        hold_s: float = 0.0,
        within_m: float = 0.0,
        heading_deg: float | None = None,
    ) -> "Mission":
        """Go to a place by latitude and longitude; otherwise as `go`."""
        item = _waypoint(altitude_m, hold_s, within_m, heading_deg)
        return self._then(Step(replace(item, x=latitude_deg, y=longitude_deg)))

    def survey(
        self,
        south_west: tuple[float, float],
        north_east: tuple[float, float],
        altitude_m: float,
        *,
        spacing_m: float,
    ) -> "Mission":
        """Fly north and south over a rectangle, in lines at most `spacing_m` apart, from west to east.

        Args:
            south_west: a corner, metres north and east of home.
            north_east: the corner opposite.
            altitude_m: above home.
            spacing_m: between lines.
        """
        (south, west), (north, east) = south_west, north_east
        if not (spacing_m > 0.0 and north > south and east > west):
            raise InputError("a survey needs a positive spacing, and a corner north and east of the other")
        lines = np.linspace(west, east, 1 + math.ceil((east - west) / spacing_m))
        mission = self
        for number, line in enumerate(lines):
            ends = (south, north) if number % 2 == 0 else (north, south)
            for end in ends:
                mission = mission.go(end, line, altitude_m)
        return mission

    def orbit(
        self, centre: tuple[float, float], radius_m: float, altitude_m: float, *, points: int = 12
    ) -> "Mission":
        """Fly once around a place, clockwise from its south, looking at it.

        Args:
            centre: metres north and east of home.
            radius_m: from the centre.
            altitude_m: above home.
            points: waypoints on the circle, at least 3.
        """
        if not radius_m > 0.0 or points < _LEAST_POINTS:
            raise InputError(f"an orbit needs a positive radius and at least {_LEAST_POINTS} points")
        mission = self
        for bearing in math.pi + np.linspace(0.0, 2.0 * math.pi, points + 1):
            north = centre[0] + radius_m * math.cos(bearing)
            east = centre[1] + radius_m * math.sin(bearing)
            towards_deg = math.degrees(bearing + math.pi) % 360.0
            mission = mission.go(north, east, altitude_m, heading_deg=towards_deg)
        return mission

    def speed(self, speed_m_s: float) -> "Mission":
        """Fly at that ground speed (m/s) from here on."""
        if not speed_m_s > 0.0:
            raise InputError(f"a speed must be positive (m/s), not {speed_m_s:g}")
        return self._command(mavlink.MAV_CMD_DO_CHANGE_SPEED, (1.0, float(speed_m_s), -1.0, 0.0))

    def repeat(self, from_step: int, times: int) -> "Mission":
        """Go back to step `from_step` (the first is 0), that many times; -1 for ever."""
        return self._command(mavlink.MAV_CMD_DO_JUMP, (float(from_step), float(times), 0.0, 0.0))

    def land(self, north_m: float, east_m: float) -> "Mission":
        """Land there, in metres from home."""
        land = MissionItem(mavlink.MAV_CMD_NAV_LAND, Frame.ABOVE_HOME, (0.0, 0.0, 0.0, None))
        return self._then(Step(land, (float(north_m), float(east_m))))

    def return_home(self) -> "Mission":
        """Return in the autopilot's own way, and land."""
        return self._command(mavlink.MAV_CMD_NAV_RETURN_TO_LAUNCH)

    def _command(self, command: int, params: Parameters = (0.0, 0.0, 0.0, 0.0)) -> "Mission":
        return self._then(Step(MissionItem(command, params=params)))

    def _then(self, step: Step) -> "Mission":
        return Mission((*self.steps, step))


def _waypoint(altitude_m: float, hold_s: float, within_m: float, heading_deg: float | None) -> MissionItem:
    params = (float(hold_s), float(within_m), 0.0, heading_deg)
    return MissionItem(mavlink.MAV_CMD_NAV_WAYPOINT, Frame.ABOVE_HOME, params, z=float(altitude_m))
