"""How fast to go along straight legs and round the corners between them: a series of velocity steps.

Between two steps the path is straight to the last bit; in one it stays between the two legs, so that it
overshoots nowhere. Steps do not overlap, and each reaches its limit of acceleration or jerk.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from companion.arrays import Vec3
from companion.trajectory.limits import Peaks
from companion.trajectory.velocity_step import VelocityStep, velocity_step

_STRAIGHT = 1e-6
"""A turn by less than this (rad) is none."""
_HALVINGS = 30


@dataclass(frozen=True, slots=True, eq=False)
class Waypoint:
    """A place on the way.

    Attributes:
        position: NED (m).
        within_m: how near the path must come (m); 0 stops there.
        hold_s: how long to stay exactly there (s); 0 flies on.
        speed_m_s: the most on the leg that leads here (m/s); by default PX4's MPC_XY_CRUISE.
    """

    position: Vec3
    within_m: float = 1.0
    hold_s: float = 0.0
    speed_m_s: float = 5.0


@dataclass(frozen=True, slots=True, eq=False)
class TimedStep:
    """A change of velocity (m/s) that begins at an instant (s), at a position (m) with a velocity (m/s)."""

    start_s: float
    position: Vec3
    velocity: Vec3
    change: Vec3
    shape: VelocityStep


@dataclass(frozen=True, slots=True, eq=False)
class _Change:
    """What the velocity changes by for each m/s of speed, and how quickly it may.

    Along a leg `vector` is its direction; at a corner it is the one direction less the other.
    """

    vector: Vec3
    size: float
    acceleration_m_s2: float
    jerk_m_s3: float

    def step(self, speed_m_s: float) -> VelocityStep:
        """The shortest step by `speed_m_s` times the vector."""
        return velocity_step(speed_m_s * self.size, self.acceleration_m_s2, self.jerk_m_s3)

    def half_m(self, speed_m_s: float) -> float:
        """How far before a corner the turn begins, and after it ends (m)."""
        return 0.5 * speed_m_s * self.step(speed_m_s).duration_s if self.size else 0.0

    def distance_m(self, before_m_s: float, after_m_s: float) -> float:
        """How far a change of speed along a leg goes (m)."""
        if before_m_s == after_m_s:
            return 0.0
        return 0.5 * (before_m_s + after_m_s) * self.step(abs(after_m_s - before_m_s)).duration_s


@dataclass(frozen=True, slots=True, eq=False)
class _Leg:
    """A straight line from `start` (m, NED): its direction, its length (m), its greatest speed (m/s)."""

    start: Vec3
    along: _Change
    length_m: float
    top_m_s: float


class Route:
    """Legs between waypoints, no two of which are at the same place, and how fast each waypoint is passed."""

    def __init__(self, waypoints: Sequence[Waypoint], allowed: Peaks) -> None:
        self._holds_s = [waypoint.hold_s for waypoint in waypoints]
        self._legs = [_leg(start, end, allowed) for start, end in pairwise(waypoints)]
        at_rest = _change(np.zeros(3), allowed)
        turns = (
            _change(end.along.vector - start.along.vector, allowed) for start, end in pairwise(self._legs)
        )
        self._turns = [at_rest, *turns, at_rest]
        corners = zip(waypoints[1:-1], self._turns[1:-1], pairwise(self._legs), strict=True)
        self._speeds = [0.0, *(_corner_speed(*corner) for corner in corners), 0.0]
        for index in reversed(range(len(self._legs))):
            self._make_room(index, faster=index, slower=index + 1)
        for index in range(len(self._legs)):
            self._make_room(index, faster=index + 1, slower=index)

    def schedule(self) -> tuple[list[TimedStep], float]:
        """All steps in order of time, and when the last waypoint's hold is over (s)."""
        steps: list[TimedStep] = []
        now_s = self._holds_s[0]

        def step(leg: _Leg, place_m: float, speed_m_s: float, change: _Change, amount_m_s: float) -> None:
            nonlocal now_s
            position, velocity = leg.start + place_m * leg.along.vector, speed_m_s * leg.along.vector
            shape = change.step(abs(amount_m_s))
            steps.append(TimedStep(now_s, position, velocity, amount_m_s * change.vector, shape))
            now_s += shape.duration_s

        for index, leg in enumerate(self._legs):
            place_m = self._half_m(index)
            for before, after, begins_m in self._speed_changes(index):
                now_s += _time_s(begins_m - place_m, before)
                step(leg, begins_m, before, leg.along, after - before)
                place_m = begins_m + leg.along.distance_m(before, after)
            last = index + 1
            corner_m = leg.length_m - self._half_m(last)
            now_s += _time_s(corner_m - place_m, self._speeds[last])
            if self._half_m(last):
                step(leg, corner_m, self._speeds[last], self._turns[last], self._speeds[last])
            now_s += self._holds_s[last]
        return steps, now_s

    def _speed_changes(self, index: int) -> Iterator[tuple[float, float, float]]:
        """The changes of speed on a leg: from, to (m/s), and where on the leg each begins (m)."""
        leg, first, last = self._legs[index], self._speeds[index], self._speeds[index + 1]
        begins_m, ends_m = self._half_m(index), leg.length_m - self._half_m(index + 1)

        def fits(cruise: float) -> bool:
            changes_m = leg.along.distance_m(first, cruise) + leg.along.distance_m(cruise, last)
            return begins_m + changes_m <= ends_m

        cruise = _fastest(max(first, last), leg.top_m_s, fits)
        if cruise != first:
            yield first, cruise, begins_m
        if cruise != last:
            yield cruise, last, ends_m - leg.along.distance_m(cruise, last)

    def _make_room(self, index: int, *, faster: int, slower: int) -> None:
        """Lower the speed at the faster end of a leg until there is room to change to that at the other."""
        leg, low = self._legs[index], self._speeds[slower]

        def fits(speed_m_s: float) -> bool:
            corners_m = self._turns[faster].half_m(speed_m_s) + self._half_m(slower)
            return corners_m + leg.along.distance_m(speed_m_s, low) <= leg.length_m

        if self._speeds[faster] > low:
            self._speeds[faster] = _fastest(low, self._speeds[faster], fits)

    def _half_m(self, at: int) -> float:
        return self._turns[at].half_m(self._speeds[at])


def _corner_speed(waypoint: Waypoint, turn: _Change, legs: tuple[_Leg, _Leg]) -> float:
    """How fast a waypoint may be passed (m/s): near enough to it, and within half of either leg."""
    if waypoint.hold_s > 0.0:
        return 0.0
    top_m_s = min(leg.top_m_s for leg in legs)
    room_m = 0.5 * min(leg.length_m for leg in legs)

    def allowed(speed_m_s: float) -> bool:
        cut_m = turn.size * speed_m_s * turn.step(speed_m_s).cut_s
        return cut_m <= waypoint.within_m and turn.half_m(speed_m_s) <= room_m

    return _fastest(0.0, top_m_s, allowed)


def _leg(start: Waypoint, end: Waypoint, allowed: Peaks) -> _Leg:
    line = end.position - start.position
    length_m = float(np.linalg.norm(line))
    direction = line / length_m
    top_m_s = min(end.speed_m_s, allowed.speed_m_s)
    if direction[2]:
        vertical_m_s = allowed.down_m_s if direction[2] > 0.0 else allowed.up_m_s
        top_m_s = min(top_m_s, vertical_m_s / abs(float(direction[2])))
    return _Leg(start.position, _change(direction, allowed), length_m, top_m_s)


def _change(vector: Vec3, allowed: Peaks) -> _Change:
    size, vertical = float(np.linalg.norm(vector)), abs(float(vector[2]))
    acceleration_m_s2 = allowed.acceleration_m_s2
    if vertical:
        acceleration_m_s2 = min(acceleration_m_s2, allowed.vertical_acceleration_m_s2 * size / vertical)
    return _Change(vector, size if size > _STRAIGHT else 0.0, acceleration_m_s2, allowed.jerk_m_s3)


def _time_s(distance_m: float, speed_m_s: float) -> float:
    """How long it takes; at rest there is no distance left but by rounding."""
    return distance_m / speed_m_s if speed_m_s else 0.0


def _fastest(low: float, high: float, allowed: Callable[[float], bool]) -> float:
    """The highest speed from `low`, which is allowed, to `high`; slower is allowed where faster is."""
    if high <= low:
        return low
    if allowed(high):
        return high
    for _ in range(_HALVINGS):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if allowed(middle) else (low, middle)
    return low
