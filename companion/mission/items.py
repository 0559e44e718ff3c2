"""A plan as MAVLink has it: mission, fence and rally points, in degrees and metres.

What is not given is None, never NaN. Sequence numbers are positions in `Plan.mission`, from 0; ArduPilot's
item 0, its home, is `Plan.home`, and is added and taken off where bytes are sent and files are read.
"""

import math
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import astuple, dataclass, replace
from enum import IntEnum
from typing import TypeAlias

from companion.errors import InputError
from companion.geodesy import Place
from companion.link.dialect import mavlink
from companion.mission.commands import LOCATED, WAYPOINTS, command_name, is_known

HIGHEST_M = 100_000.0
"""No altitude may be farther from zero (m)."""

MOST_ITEMS = 5_000
"""More than autopilots store: what is longer is a mistake."""

Parameters: TypeAlias = tuple[float | None, float | None, float | None, float | None]


class Frame(IntEnum):
    """What the place of an item is relative to: MAV_FRAME, as far as missions use it."""

    GLOBAL = mavlink.MAV_FRAME_GLOBAL
    """Altitude above mean sea level."""
    NONE = mavlink.MAV_FRAME_MISSION
    """The item has no place."""
    ABOVE_HOME = mavlink.MAV_FRAME_GLOBAL_RELATIVE_ALT
    ABOVE_TERRAIN = mavlink.MAV_FRAME_GLOBAL_TERRAIN_ALT


_OTHER_NUMBERS = {
    mavlink.MAV_FRAME_GLOBAL_INT: Frame.GLOBAL,
    mavlink.MAV_FRAME_GLOBAL_RELATIVE_ALT_INT: Frame.ABOVE_HOME,
    mavlink.MAV_FRAME_GLOBAL_TERRAIN_ALT_INT: Frame.ABOVE_TERRAIN,
}
"""The same frames, with the integers of the wire in mind."""


def frame_from_number(number: int) -> Frame:
    """The frame of a MAV_FRAME.

    Raises:
        InputError: missions have no such frame.
    """
    try:
        return Frame(_OTHER_NUMBERS.get(number, number))
    except ValueError:
        known = ", ".join(f"{frame.value}" for frame in Frame)
        raise InputError(f"frame {number} is none of a mission's: expected {known}") from None


@dataclass(frozen=True, slots=True)
class MissionItem:
    """One command of a mission.

    Attributes:
        command: MAV_CMD.
        frame: what `altitude_m` is above.
        params: parameters 1 to 4, in the command's own units; None leaves one to the autopilot.
        x, y: latitude and longitude (degrees) of a command that has a place; else parameters 5 and 6.
        z: altitude (m) of a command that has a place; else parameter 7.
        autocontinue: whether the next item follows by itself.

    Raises:
        InputError: the command is not known, a number is not finite, or the place is none on earth.
    """

    command: int
    frame: Frame = Frame.NONE
    params: Parameters = (0.0, 0.0, 0.0, 0.0)
    x: float | None = 0.0
    y: float | None = 0.0
    z: float | None = 0.0
    autocontinue: bool = True

    def __post_init__(self) -> None:
        if not is_known(self.command):
            raise InputError(f"command {self.command} is none that MAVLink knows")
        numbers = (*self.params, self.x, self.y, self.z)
        if not all(math.isfinite(number) for number in numbers if number is not None):
            raise InputError(f"{self.name}: every parameter must be a finite number")
        if self.has_place:
            require_on_earth(self.x, self.y, self.z)
        if self.command in WAYPOINTS and None in (self.x, self.y, self.z):
            raise InputError(f"{self.name}: latitude, longitude and altitude must be given")

    @property
    def name(self) -> str:
        """The name of the command, such as NAV_WAYPOINT."""
        return command_name(self.command)

    @property
    def has_place(self) -> bool:
        """Whether x, y and z mean a place on earth."""
        return self.command in LOCATED and self.frame is not Frame.NONE

    def jumping(self, by: int) -> "MissionItem":
        """The item; where it jumps, to a target that is moved by so many items."""
        if self.command != mavlink.MAV_CMD_DO_JUMP or self.params[0] is None:
            return self
        return replace(self, params=(self.params[0] + by, *self.params[1:]))

    @property
    def coordinates(self) -> tuple[float, float] | None:
        """Latitude and longitude (degrees); None where it has no place, or means the vehicle's own.

        Latitude and longitude that are both 0 mean the vehicle's own, as ArduPilot has it.
        """
        if not self.has_place or self.x is None or self.y is None or self.x == self.y == 0.0:
            return None
        return self.x, self.y

    def place(self, home: Place) -> Place | None:
        """Where it is; None as `coordinates`. Terrain is taken to be as high as home."""
        if self.coordinates is None:
            return None
        ground_m = 0.0 if self.frame is Frame.GLOBAL else home.altitude_m
        return Place(*self.coordinates, ground_m + (self.z or 0.0))


@dataclass(frozen=True, slots=True)
class FencePolygon:
    """An area that the vehicle must stay in, or out of.

    Attributes:
        vertices: latitude and longitude (degrees) of at least three corners.
        inclusion: stay in; else out.
    """

    vertices: tuple[tuple[float, float], ...]
    inclusion: bool = True

    def __post_init__(self) -> None:
        if len(self.vertices) < 3:
            raise InputError(f"a fence polygon has at least 3 corners, not {len(self.vertices)}")
        for latitude_deg, longitude_deg in self.vertices:
            require_on_earth(latitude_deg, longitude_deg)


@dataclass(frozen=True, slots=True)
class FenceCircle:
    """A circle (degrees, m) that the vehicle must stay in, or out of."""

    latitude_deg: float
    longitude_deg: float
    radius_m: float
    inclusion: bool = True

    def __post_init__(self) -> None:
        require_on_earth(self.latitude_deg, self.longitude_deg)
        if not 0.0 < self.radius_m < math.inf:
            raise InputError(f"the radius of a fence circle (m) must be positive, not {self.radius_m:g}")


@dataclass(frozen=True, slots=True)
class Fence:
    """Where the vehicle may be.

    Attributes:
        polygons, circles: inclusion areas it must stay in, exclusion areas it must stay out of.
        breach_return: where it goes when it did not; the altitude is above home.
    """

    polygons: tuple[FencePolygon, ...] = ()
    circles: tuple[FenceCircle, ...] = ()
    breach_return: Place | None = None

    def __bool__(self) -> bool:
        return bool(self.polygons or self.circles or self.breach_return)


@dataclass(frozen=True, slots=True)
class Plan:
    """All that a plan file holds.

    Attributes:
        mission: the items, in order; jumps (DO_JUMP, parameter 1) name positions in it, from 0.
        fence: where the vehicle may be.
        rally: places to return to other than home; their altitudes are above home.
        home: planned home; None where it is not known.
        cruise_speed_m_s, hover_speed_m_s: what the plan was made for (m/s): planes, multirotors.
        firmware: MAV_AUTOPILOT that it was made for.
    """

    mission: tuple[MissionItem, ...] = ()
    fence: Fence = Fence()
    rally: tuple[Place, ...] = ()
    home: Place | None = None
    cruise_speed_m_s: float = 15.0
    hover_speed_m_s: float = 5.0
    firmware: int = mavlink.MAV_AUTOPILOT_PX4

    def __post_init__(self) -> None:
        if len(self.mission) > MOST_ITEMS:
            raise InputError(
                f"{len(self.mission)} items: no more than {MOST_ITEMS} are taken; split the mission"
            )
        places = {"home": self.home, "breach return": self.fence.breach_return}
        places |= {f"rally point {index}": place for index, place in enumerate(self.rally)}
        for name, place in places.items():
            if place is not None:
                with naming(name):
                    require_on_earth(*astuple(place))
        for index, item in enumerate(self.mission):
            if item.command == mavlink.MAV_CMD_DO_JUMP and item.params[0] not in range(len(self.mission)):
                raise InputError(f"item {index}: it jumps to item {item.params[0]}, which is not there")


@contextmanager
def naming(what: str) -> Iterator[None]:
    """Have an InputError of the block begin with `what` is wrong."""
    try:
        yield
    except InputError as error:
        raise InputError(f"{what}: {error}") from error


def require_on_earth(
    latitude_deg: float | None, longitude_deg: float | None, altitude_m: float | None = None
) -> None:
    """InputError unless what is given of a place (degrees, m) is on earth."""
    for value, limit, what in (
        (latitude_deg, 90.0, "latitude (degrees)"),
        (longitude_deg, 180.0, "longitude (degrees)"),
        (altitude_m, HIGHEST_M, "altitude (m)"),
    ):
        if value is not None and not -limit <= value <= limit:
            raise InputError(f"{what} {value:g} is out of range: expected -{limit:g} to {limit:g}")
