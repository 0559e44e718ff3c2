"""What of a plan can be tracked: its waypoints, in metres from the takeoff point, and how it ends.

| command                                            | what becomes of it                                   |
|----------------------------------------------------|------------------------------------------------------|
| NAV_TAKEOFF, first                                 | the height of takeoff, straight up                   |
| NAV_WAYPOINT, NAV_LOITER_TO_ALT                    | a waypoint: hold, acceptance radius                  |
| NAV_SPLINE_WAYPOINT                                | a waypoint between straight legs, and that is said   |
| NAV_LOITER_TIME, NAV_DELAY                         | a hold                                               |
| NAV_LOITER_TURNS                                   | circles                                              |
| NAV_LOITER_UNLIM, NAV_LAND, NAV_RETURN_TO_LAUNCH   | the end: hold there, land there, return              |
| DO_CHANGE_SPEED                                    | the speed of the legs that follow                    |
| DO_JUMP                                            | the items again, as often as it says                 |
| other NAV commands, DO_SET_HOME                    | refused                                              |
| yaw (parameter 4), other than 0                    | left out, and that is said                           |
| other DO and CONDITION commands (cameras, yaw, …)  | left out, and that is said                           |
"""

import math
from collections import Counter, defaultdict
from collections.abc import Iterator
from dataclasses import dataclass, replace
from enum import Enum, auto

import numpy as np

from companion.arrays import Vec3
from companion.errors import InputError
from companion.link.dialect import mavlink
from companion.mission.items import Frame, MissionItem, Plan
from companion.mission.site import Site
from companion.trajectory.route import Waypoint

MOST_STEPS = 20_000
"""More items than this, jumps unrolled, are a mistake."""
WITHIN_M = 1.0
"""How near a waypoint is passed where the plan does not say."""
_CIRCLE_WITHIN_M = 0.1
_LAST_NAV = mavlink.MAV_CMD_NAV_LAST
_GROUND_OR_AIR_SPEED = (0, 1)
_OF_THE_FLIGHT = (
    mavlink.MAV_CMD_NAV_LAND,
    mavlink.MAV_CMD_NAV_VTOL_LAND,
    mavlink.MAV_CMD_NAV_RETURN_TO_LAUNCH,
    mavlink.MAV_CMD_NAV_LOITER_UNLIM,
)
_WITH_YAW = (
    mavlink.MAV_CMD_NAV_TAKEOFF,
    mavlink.MAV_CMD_NAV_WAYPOINT,
    mavlink.MAV_CMD_NAV_LOITER_UNLIM,
    mavlink.MAV_CMD_NAV_LAND,
)
_SILENT = (mavlink.MAV_CMD_DO_LAND_START, mavlink.MAV_CMD_NAV_LAST)
"""Markers that ask for nothing."""


class Ending(Enum):
    """What the vehicle is told when the path is done."""

    HOLD = auto()
    LAND = auto()
    RETURN = auto()


@dataclass(frozen=True, slots=True, eq=False)
class TrackedPath:
    """A plan as it can be tracked.

    Attributes:
        waypoints: NED from the takeoff point (m); the first is where the vehicle is, or is brought to.
        items: the plan's item that each waypoint comes from, from 0; None for the first.
        takeoff_altitude_m: how high to take off (m).
        ending: what comes afterwards.
        remarks: what is flown otherwise than the plan says, in words.
    """

    waypoints: tuple[Waypoint, ...]
    items: tuple[int | None, ...]
    takeoff_altitude_m: float
    ending: Ending
    remarks: tuple[str, ...]

    def name(self, waypoint: int) -> str:
        """What to call a waypoint: by its item, as the plan has it."""
        item = self.items[waypoint]
        return "the start" if item is None else f"item {item}"


def tracked_path(plan: Plan, site: Site) -> TrackedPath:
    """The path of `plan`, flown from `site`.

    Raises:
        InputError: it has no waypoint, or an item that cannot be tracked; names the item.
    """
    walk = _Walk(plan, site)
    for index in _unrolled(plan.mission):
        try:
            walk.take(index, plan.mission[index])
        except InputError as error:
            raise InputError(f"item {index} ({plan.mission[index].name}): {error}") from error
        if walk.ending is not None:
            break
    return walk.path()


class _Walk:
    """The plan taken item by item."""

    def __init__(self, plan: Plan, site: Site) -> None:
        self.ending: Ending | None = None
        self._site = site
        self._speed_m_s = self._usual_m_s = plan.hover_speed_m_s
        self._waypoints: list[Waypoint] = []
        self._items: list[int | None] = []
        self._takeoff_altitude_m: float | None = None
        self._left_out: defaultdict[str, list[int]] = defaultdict(list)

    def take(self, index: int, item: MissionItem) -> None:
        """Take one item; InputError where it cannot be tracked."""
        hold_s = item.params[0] or 0.0
        if item.command in _WITH_YAW and item.params[3]:
            self._left_out["without the yaw given"].append(index)
        match item.command:
            case mavlink.MAV_CMD_NAV_TAKEOFF | mavlink.MAV_CMD_NAV_VTOL_TAKEOFF:
                self._take_off(item)
            case mavlink.MAV_CMD_NAV_WAYPOINT:
                self._go(index, item, hold_s, item.params[1])
            case mavlink.MAV_CMD_NAV_SPLINE_WAYPOINT:
                self._left_out["straight legs instead of the curve of NAV_SPLINE_WAYPOINT"].append(index)
                self._go(index, item, hold_s, None)
            case mavlink.MAV_CMD_NAV_LOITER_TIME:
                self._go(index, item, hold_s, None)
            case mavlink.MAV_CMD_NAV_LOITER_TO_ALT:
                self._go(index, item, 0.0, None)
            case mavlink.MAV_CMD_NAV_LOITER_TURNS:
                self._circle(index, item)
            case mavlink.MAV_CMD_NAV_DELAY:
                self._wait(hold_s)
            case mavlink.MAV_CMD_DO_CHANGE_SPEED if item.params[0] in _GROUND_OR_AIR_SPEED:
                self._change_speed(item.params[1])
            case command if command in _OF_THE_FLIGHT:
                self._end(index, item)
            case command if command in _SILENT:
                pass
            case mavlink.MAV_CMD_DO_SET_HOME:
                raise InputError("a home that moves cannot be tracked: take it out of the plan")
            case command if command < _LAST_NAV:
                raise InputError("cannot be tracked: take it out, or have the autopilot fly the mission")
            case _:
                self._left_out[f"without {item.name}"].append(index)

    def path(self) -> TrackedPath:
        """What the items taken amount to."""
        if not self._waypoints:
            raise InputError("the plan has no waypoint to fly to")
        first = self._waypoints[0].position
        altitude_m = -float(first[2]) if self._takeoff_altitude_m is None else self._takeoff_altitude_m
        start = Waypoint(self._site.start(altitude_m), within_m=0.0)
        remarks = (f"{what} ({_numbers(items)})" for what, items in self._left_out.items())
        return TrackedPath(
            (start, *self._waypoints),
            (None, *self._items),
            altitude_m,
            self.ending or Ending.HOLD,
            tuple(remarks),
        )

    def _take_off(self, item: MissionItem) -> None:
        if self._waypoints or self._takeoff_altitude_m is not None:
            raise InputError("only the first item of a flight can be its takeoff: split the plan there")
        self._takeoff_altitude_m = -float(self._position(item)[2])
        if self._takeoff_altitude_m <= 0.0:
            raise InputError(f"a takeoff to {self._takeoff_altitude_m:g} m above the ground is none")

    def _go(self, index: int, item: MissionItem, hold_s: float, within_m: float | None) -> None:
        if hold_s < 0.0 or (within_m or 0.0) < 0.0:
            raise InputError("hold and acceptance radius (parameters 1 and 2) must not be negative")
        self._add(index, Waypoint(self._position(item), within_m or WITHIN_M, hold_s, self._speed_m_s))

    def _wait(self, hold_s: float) -> None:
        if hold_s < 0.0:
            raise InputError("a delay until a time of day cannot be tracked: give seconds in parameter 1")
        if self._waypoints:
            last = self._waypoints[-1]
            self._waypoints[-1] = replace(last, hold_s=last.hold_s + hold_s)

    def _circle(self, index: int, item: MissionItem) -> None:
        """Turns about a centre, from the nearest point on; clockwise where the radius is positive."""
        turns, radius_m = item.params[0] or 0.0, item.params[2] or 0.0
        if turns <= 0.0 or radius_m == 0.0:
            raise InputError("turns (parameter 1) must be positive, and a radius (m, parameter 3) be given")
        centre = self._position(item)
        came = (self._waypoints[-1].position if self._waypoints else np.zeros(3)) - centre
        per_turn = max(12, math.ceil(math.pi / math.sqrt(2.0 * _CIRCLE_WITHIN_M / abs(radius_m))))
        count = math.ceil(turns * per_turn)
        if count > MOST_STEPS:
            raise InputError(f"{turns:g} turns of {radius_m:g} m are more than can be flown")
        angles = math.atan2(came[1], came[0]) + np.linspace(0.0, turns * math.tau, count + 1) * np.sign(
            radius_m
        )
        for angle in angles:
            offset = abs(radius_m) * np.array([math.cos(angle), math.sin(angle), 0.0])
            self._add(index, Waypoint(centre + offset, _CIRCLE_WITHIN_M, 0.0, self._speed_m_s))

    def _change_speed(self, speed_m_s: float | None) -> None:
        if speed_m_s == -2.0:  # the vehicle's own
            self._speed_m_s = self._usual_m_s
        elif speed_m_s is not None and speed_m_s >= 0.0:
            if speed_m_s == 0.0:
                raise InputError("a speed of 0 m/s never gets anywhere")
            self._speed_m_s = speed_m_s

    def _end(self, index: int, item: MissionItem) -> None:
        match item.command:
            case mavlink.MAV_CMD_NAV_RETURN_TO_LAUNCH:
                self.ending = Ending.RETURN
            case mavlink.MAV_CMD_NAV_LOITER_UNLIM:
                self.ending = Ending.HOLD
                self._go(index, item, 0.0, None)
            case _:
                self.ending = Ending.LAND
                if item.coordinates is not None:
                    above = self._position(item)
                    above[2] = self._altitude_now()
                    self._add(index, Waypoint(above, WITHIN_M, 0.0, self._speed_m_s))

    def _position(self, item: MissionItem) -> Vec3:
        """Where an item is (NED from the takeoff point, m); what it leaves open stays as it is."""
        if item.frame is Frame.ABOVE_TERRAIN:
            raise InputError("heights above terrain cannot be tracked: give them above home or above sea")
        position = self._waypoints[-1].position.copy() if self._waypoints else self._site.start(0.0)
        if item.coordinates is not None:
            position[:2] = self._site.horizontal(*item.coordinates)
        if item.z is not None:
            position[2] = -item.z if item.frame is not Frame.GLOBAL else self._site.down(item.z)
        return position

    def _altitude_now(self) -> float:
        """Down of the last waypoint (m)."""
        if self._waypoints:
            return float(self._waypoints[-1].position[2])
        return -(self._takeoff_altitude_m or 0.0)

    def _add(self, index: int, waypoint: Waypoint) -> None:
        self._waypoints.append(waypoint)
        self._items.append(index)


def _unrolled(items: tuple[MissionItem, ...]) -> Iterator[int]:
    """The indices of the items in the order in which they are flown; jumps end after their repetitions."""
    jumped: Counter[int] = Counter()
    index = 0
    for _ in range(MOST_STEPS):
        if index >= len(items):
            return
        item = items[index]
        if item.command != mavlink.MAV_CMD_DO_JUMP:
            yield index
            index += 1
            continue
        target, repeats = item.params[0] or 0.0, item.params[1] or 0.0
        if repeats < 0.0:
            raise InputError(f"item {index} ({item.name}): it jumps for ever: give a number of repetitions")
        again = jumped[index] < repeats
        jumped[index] += 1
        index = int(target) if again else index + 1
    raise InputError(f"the plan's jumps make more than {MOST_STEPS} items of it: repeat less")


def _numbers(items: list[int]) -> str:
    """Items in words, the first few of many."""
    shown = ", ".join(map(str, items[:5]))
    return f"item{'s' if len(items) > 1 else ''} {shown}{' and others' if len(items) > 5 else ''}"
