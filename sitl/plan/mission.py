"""Flies a mission item by item: which is current, when it is done, and what to fly for it.

https://mavlink.io/en/messages/common.html#mav_commands says what the items mean; where PX4 and ArduPilot
differ, `MissionRules` has it. Knows no controller: it hands out legs, and is told where the vehicle is.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass
from enum import Enum, auto

import numpy as np

from sitl.arrays import Vec3
from sitl.geodesy import PX4_EARTH_M
from sitl.plan.items import Command, Item, Plan
from sitl.plan.places import GLOBAL, local_place

_FOREVER = -1
_MOST_STEPS = 1000
"""Items without flight that are done in one go: a loop of jumps must not stop the clock."""


class MissionState(Enum):
    """How far a mission is (MISSION_STATE)."""

    NO_MISSION = 1
    NOT_STARTED = 2
    ACTIVE = 3
    PAUSED = 4
    COMPLETE = 5


class Flight(Enum):
    """What a leg asks for."""

    CLIMB = auto()  # straight up to the place's height
    GO = auto()
    CIRCLE = auto()
    LAND = auto()  # straight down, at the place
    RETURN = auto()
    STAY = auto()  # wherever that is


@dataclass(frozen=True, slots=True, eq=False)
class Leg:
    """What to fly now.

    Attributes:
        flight: how.
        place: NED (m): where to, the middle of a circle, or where to land.
        yaw: rad; NaN is up to the vehicle.
        radius: of a circle (m), negative anticlockwise.
    """

    flight: Flight
    place: Vec3
    yaw: float = math.nan
    radius: float = 0.0


@dataclass(frozen=True, slots=True, eq=False)
class Situation:
    """What decides whether an item is done.

    Attributes:
        time_s: now (s).
        position: estimated, NED (m).
        yaw: estimated (rad).
        home: NED (m).
        landed: on the ground.
        radius: horizontal distance (m) at which a place is reached, unless its item has its own.
        height: vertical distance (m) at which it is.
    """

    time_s: float
    position: Vec3
    yaw: float
    home: Vec3
    landed: bool
    radius: float
    height: float


@dataclass(frozen=True, slots=True)
class MissionRules:
    """Where autopilots differ.

    Attributes:
        first: the first item that is flown; before it is home.
        waypoint_params: whether a waypoint has its own radius (m) and heading (degrees), parameters 2 and 4.
        reports_every_item: whether commands count as reached, too, and not navigation alone.
        earth_radius_m: by which places on the map are local.
        climbs_first: whether a mission that begins on the ground without a takeoff gets one.
    """

    first: int
    waypoint_params: bool
    reports_every_item: bool
    climbs_first: bool
    earth_radius_m: float = PX4_EARTH_M


_YAW_REACHED = math.radians(12.0)
"""PX4's MIS_YAW_ERR."""


class Mission:
    """A mission plan, and how far its flight is.

    Args:
        rules: of the autopilot.
        perform: does what a command item asks for, at once.

    Attributes:
        plan: what is flown.
        current: number of the item that is flown, or will be first.
        reached: numbers of items that were reached or done, oldest first, until taken.
    """

    def __init__(self, rules: MissionRules, perform: Callable[[Item], None]) -> None:
        self._rules = rules
        self._perform = perform
        self.reached: list[int] = []
        self.load(Plan(), 0)

    def load(self, plan: Plan, current: int) -> None:
        """Another plan, from its item `current`."""
        self.plan = plan
        self._jumps: dict[int, int] = {}
        self._complete = False
        self._begun = False
        self.reached.clear()
        self.go_to(current)

    def go_to(self, number: int) -> None:
        """Continue at an item."""
        self.current = max(number, self._rules.first)
        self._complete = False
        self._leg: Leg | None = None
        self.pause()

    def restart(self) -> None:
        """Back to the first item, all jumps still to be made."""
        self._jumps.clear()
        self._begun = False
        self.go_to(self._rules.first)

    def pause(self) -> None:
        """Leave it; the next update begins the current item again."""
        self._leg = None
        self._arrived_s: float | None = None
        self._turned = 0.0
        self._bearing = math.nan

    def take_reached(self) -> list[int]:
        """The numbers of items that were reached since the last call, oldest first."""
        reached, self.reached = self.reached, []
        return reached

    @property
    def exists(self) -> bool:
        """Whether there is anything to fly."""
        return len(self.plan) > self._rules.first

    @property
    def starts_with_takeoff(self) -> bool:
        """Whether the item that comes first, commands aside, is a takeoff."""
        following = (item for item in self.plan.items[self.current :] if item.is_navigation)
        item = next(following, None)
        return item is not None and item.command == Command.NAV_TAKEOFF

    @property
    def state(self) -> MissionState:
        """How far it is."""
        if not self.exists:
            return MissionState.NO_MISSION
        if self._complete:
            return MissionState.COMPLETE
        if self._leg is not None:
            return MissionState.ACTIVE
        return MissionState.PAUSED if self._begun else MissionState.NOT_STARTED

    @property
    def complete(self) -> bool:
        """Whether the last item is done."""
        return self._complete

    @property
    def looks(self) -> bool:
        """Whether the heading may follow a region of interest: on the way and in a hold."""
        leg = self._leg
        return leg is not None and leg.flight in (Flight.GO, Flight.STAY) and math.isnan(leg.yaw)

    def update(self, now: Situation) -> Leg | None:
        """Move on; the leg to fly from now on, None to fly on as before, or when the mission is complete."""
        self._begun = True
        if self._leg is not None:
            if not self._is_done(self._leg, now):
                return None
            if self._is_first_climb(self._leg):
                self.pause()
            else:
                self._finish_item(report=True)
        for _ in range(_MOST_STEPS):
            if self._complete:
                return None
            if self.current >= len(self.plan):
                self._complete = True
                self.current = max(len(self.plan) - 1, self._rules.first)
                return None
            item = self.plan.items[self.current]
            if item.is_navigation or item.command == Command.CONDITION_DELAY:
                self._leg = self._begin(item, now)
                return self._leg
            if item.command == Command.DO_JUMP:
                self._jump(item)
            else:
                self._perform(item)
                self._finish_item(report=self._rules.reports_every_item)
        return None

    def _is_first_climb(self, leg: Leg) -> bool:
        command = self.plan.items[self.current].command
        return leg.flight is Flight.CLIMB and command != Command.NAV_TAKEOFF

    def _finish_item(self, *, report: bool) -> None:
        if report:
            self.reached.append(self.current)
        self.current += 1
        self.pause()

    def _jump(self, item: Item) -> None:
        target, repeat = round(item.param(1)), round(item.param(2))
        done = self._jumps.get(self.current, 0)
        if 0 <= target < len(self.plan) and (repeat == _FOREVER or done < repeat):
            self._jumps[self.current] = done + 1
            self.current = max(target, self._rules.first)
            self.pause()
        else:
            self._finish_item(report=False)

    def _begin(self, item: Item, now: Situation) -> Leg:
        here = now.position.copy()
        place = self._place(item, now)
        if now.landed and self._rules.climbs_first and item.command not in _ON_THE_GROUND:
            return Leg(Flight.CLIMB, np.array((here[0], here[1], place[2])))
        match item.command:
            case Command.NAV_TAKEOFF:
                return Leg(Flight.CLIMB, np.array((here[0], here[1], place[2])), self._yaw(item))
            case Command.NAV_LAND:
                return Leg(Flight.LAND, np.array((place[0], place[1], here[2])))
            case Command.NAV_RETURN_TO_LAUNCH:
                return Leg(Flight.RETURN, now.home)
            case Command.NAV_LOITER_TURNS:
                return Leg(Flight.CIRCLE, place, radius=item.param(3))
            case Command.NAV_DELAY | Command.CONDITION_DELAY:
                return Leg(Flight.STAY, here)
            case _:
                return Leg(Flight.GO, place, self._yaw(item))

    def _place(self, item: Item, now: Situation) -> Vec3:
        """Where an item is; without latitude and longitude (both 0), or a global frame, above the vehicle."""
        if item.frame not in GLOBAL:
            return now.position.copy()
        place = local_place(item, now.home, self._rules.earth_radius_m)
        if item.x == item.y == 0:
            place[:2] = now.position[:2]
        return place

    def _yaw(self, item: Item) -> float:
        has_yaw = self._rules.waypoint_params and item.command in _WITH_YAW
        return math.radians(item.params[3]) if has_yaw else math.nan

    def _is_done(self, leg: Leg, now: Situation) -> bool:
        item = self.plan.items[self.current]
        match leg.flight:
            case Flight.LAND:
                return now.landed
            case Flight.RETURN:
                return False
            case Flight.CLIMB:
                return abs(float(now.position[2] - leg.place[2])) < now.height and not now.landed
            case Flight.STAY:
                return self._has_stayed(max(item.param(1), 0.0), now)
            case Flight.CIRCLE:
                return self._has_circled(leg, abs(item.param(1)), now)
            case Flight.GO:
                return self._has_gone(leg, item, now)

    def _has_gone(self, leg: Leg, item: Item, now: Situation) -> bool:
        away = leg.place - now.position
        radius = now.radius
        own = self._rules.waypoint_params and item.command == Command.NAV_WAYPOINT
        if own and item.param(2) > 0.0:
            radius = item.param(2)
        near = math.hypot(away[0], away[1]) < radius and abs(away[2]) < now.height
        turned = math.isnan(leg.yaw) or abs(math.remainder(leg.yaw - now.yaw, 2.0 * math.pi)) < _YAW_REACHED
        if self._arrived_s is None and not (near and turned):
            return False
        if item.command == Command.NAV_LOITER_UNLIM:
            return False
        holds = item.command in (Command.NAV_WAYPOINT, Command.NAV_SPLINE_WAYPOINT, Command.NAV_LOITER_TIME)
        return self._has_stayed(max(item.param(1), 0.0) if holds else 0.0, now)

    def _has_stayed(self, seconds: float, now: Situation) -> bool:
        if self._arrived_s is None:
            self._arrived_s = now.time_s
        return now.time_s - self._arrived_s >= seconds

    def _has_circled(self, leg: Leg, turns: float, now: Situation) -> bool:
        """Whether the vehicle has been round often enough, counted from where it came to the circle."""
        away = now.position - leg.place
        if abs(math.hypot(away[0], away[1]) - abs(leg.radius)) > max(now.radius, 1.0):
            return False
        bearing = math.atan2(away[1], away[0])
        if not math.isnan(self._bearing):
            self._turned += math.remainder(bearing - self._bearing, 2.0 * math.pi)
        self._bearing = bearing
        return abs(self._turned) >= 2.0 * math.pi * turns


_WITH_YAW = (
    Command.NAV_WAYPOINT,
    Command.NAV_LOITER_UNLIM,
    Command.NAV_LOITER_TIME,
    Command.NAV_TAKEOFF,
)
_ON_THE_GROUND = (
    Command.NAV_TAKEOFF,
    Command.NAV_LAND,
    Command.NAV_RETURN_TO_LAUNCH,
    Command.NAV_DELAY,
    Command.CONDITION_DELAY,
)
