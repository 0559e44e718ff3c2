"""Where a vehicle may be: a box, and areas on the ground, circles and polygons, to stay in or to keep out of.

North and east are from the takeoff point (m). Circles and polygons reach from the floor to the ceiling.
"""

from functools import cached_property
from typing import Annotated, Self, TypeAlias

import numpy as np
from jaxtyping import Float
from pydantic import BaseModel, ConfigDict, Field, FiniteFloat, PositiveFloat, model_validator

from companion.arrays import Array, Vec3, Vec3s
from companion.errors import InputError
from companion.flight.instants import instants
from companion.trajectory.trajectory import Trajectory

MARGIN_M = 5.0
"""A fence around a path leaves it this much room: more than the tracking error that ends a flight."""
ROUNDING_M = 1e-6

Place: TypeAlias = Float[Array, "2"]
"""North and east of the takeoff point (m)."""
Places: TypeAlias = Float[Array, "n 2"]
Corner: TypeAlias = tuple[FiniteFloat, FiniteFloat]


class Circle(BaseModel):
    """A circle, a cylinder with the fence's floor and ceiling."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    radius_m: PositiveFloat
    north_m: FiniteFloat = 0.0
    east_m: FiniteFloat = 0.0
    keep_out: bool = False

    def outside_m(self, place: Place) -> float:
        """How far outside it is (m); negative inside."""
        return float(np.linalg.norm(place - (self.north_m, self.east_m))) - self.radius_m

    def border(self, place: Place) -> Places:
        """The points of the border that may be nearest to it."""
        centre = np.array((self.north_m, self.east_m))
        away = place - centre
        distance_m = float(np.linalg.norm(away))
        direction = away / distance_m if distance_m else np.array((1.0, 0.0))
        return (centre + self.radius_m * direction)[None, :]


class Polygon(BaseModel):
    """A polygon; what is inside, the even-odd rule says."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    corners_m: Annotated[tuple[Corner, ...], Field(min_length=3, max_length=10_000)]
    """North and east of each corner."""
    keep_out: bool = False

    @cached_property
    def _edges(self) -> tuple[Places, Places]:
        """Where each begins, and how it goes on."""
        start = np.array(self.corners_m, dtype=np.float64)
        return start, np.roll(start, -1, axis=0) - start

    def outside_m(self, place: Place) -> float:
        """How far outside it is (m); negative inside."""
        start, along = self._edges
        crosses = (start[:, 0] > place[0]) != (start[:, 0] + along[:, 0] > place[0])
        slope = along[:, 1] / np.where(crosses, along[:, 0], 1.0)
        east = start[:, 1] + (place[0] - start[:, 0]) * slope
        is_inside = bool((crosses & (place[1] < east)).sum() % 2)
        distance_m = float(np.linalg.norm(self.border(place) - place, axis=1).min())
        return -distance_m if is_inside else distance_m

    def border(self, place: Place) -> Places:
        """The point of each edge that is nearest to it."""
        start, along = self._edges
        lengths = np.maximum((along * along).sum(axis=1), 1e-12)
        share = np.clip(((place - start) * along).sum(axis=1) / lengths, 0.0, 1.0)
        return np.asarray(start + share[:, None] * along)


class Areas(BaseModel):
    """Areas to keep out of, and areas of which one must be stayed in, if there are any.

    `in_all` of them is the rule of PX4 and ArduPilot, unless the latter's FENCE_OPTIONS has bit 1.
    """

    model_config = ConfigDict(frozen=True, extra="forbid")

    circles: tuple[Circle, ...] = ()
    polygons: tuple[Polygon, ...] = ()
    in_all: bool = False

    @cached_property
    def _all(self) -> tuple[Circle | Polygon, ...]:
        return (*self.circles, *self.polygons)

    def __bool__(self) -> bool:
        return bool(self._all)

    def beyond_m(self, place: Place) -> float:
        """How far it is from where the vehicle may be (m); not positive where it may."""
        outside = [(area.keep_out, area.outside_m(place)) for area in self._all]
        stay_in = [outside_m for keep_out, outside_m in outside if not keep_out]
        intrusions = [-outside_m for keep_out, outside_m in outside if keep_out]
        return max(*intrusions, (max if self.in_all else min)(stay_in, default=-np.inf), -np.inf)

    def corners(self) -> tuple[Vec3, Vec3]:
        """Least and greatest NED position of the box around it, relative to the takeoff point (m): no box."""
        return np.full(3, -np.inf), np.full(3, np.inf)

    def border(self, place: Place) -> Places:
        """The points of all borders that may be nearest to it."""
        return np.concatenate([np.zeros((0, 2)), *(area.border(place) for area in self._all)])

    def require_inside(self, trajectory: Trajectory, whose: str) -> None:
        """Refuse a trajectory, NED relative to the takeoff point, that leaves the areas.

        Args:
            trajectory: to be flown.
            whose: the areas are, for the message.

        Raises:
            InputError: it leaves them; says when, and by how much.
        """
        if not self:
            return
        times_s = instants(trajectory)
        beyond_m = [self.beyond_m(place) for place in trajectory.sample(times_s).position[:, :2]]
        worst = int(np.argmax(beyond_m))
        if beyond_m[worst] > ROUNDING_M:
            raise InputError(
                f"{trajectory.name} is {beyond_m[worst]:.2f} m beyond {whose}, {times_s[worst]:.1f} s after "
                "its beginning: move it, make it smaller, or change the fence"
            )


class Fence(Areas):
    """A box around the takeoff point, and areas, that no setpoint leaves."""

    north_m: tuple[FiniteFloat, FiniteFloat] = (-50.0, 50.0)
    east_m: tuple[FiniteFloat, FiniteFloat] = (-50.0, 50.0)
    altitude_m: tuple[FiniteFloat, FiniteFloat] = (0.5, 50.0)
    """Floor and ceiling above the takeoff point."""

    @model_validator(mode="after")
    def _low_before_high(self) -> Self:
        for name in ("north_m", "east_m", "altitude_m"):
            low, high = getattr(self, name)
            if low >= high:
                raise ValueError(f"{name}: the first number must be below the second, got {low}, {high}")
        return self

    @classmethod
    def around(cls, positions: Vec3s) -> "Fence":
        """The box `MARGIN_M` beyond these positions (NED from takeoff, m); its floor is the usual one."""
        usual = cls()
        (north, east, _), (north_most, east_most, _) = positions.min(axis=0), positions.max(axis=0)
        highest_m = max(usual.altitude_m[0], -float(positions[:, 2].min()))
        return cls(
            north_m=(north - MARGIN_M, north_most + MARGIN_M),
            east_m=(east - MARGIN_M, east_most + MARGIN_M),
            altitude_m=(usual.altitude_m[0], highest_m + MARGIN_M),
        )

    def __str__(self) -> str:
        """The box in words."""
        sides = zip(("north", "east", "altitude"), (self.north_m, self.east_m, self.altitude_m), strict=True)
        return ", ".join(f"{name} {low:.1f} to {high:.1f} m" for name, (low, high) in sides)

    def corners(self) -> tuple[Vec3, Vec3]:
        """Least and greatest NED position of the box relative to the takeoff point (m)."""
        low = np.array([self.north_m[0], self.east_m[0], -self.altitude_m[1]])
        high = np.array([self.north_m[1], self.east_m[1], -self.altitude_m[0]])
        return low, high

    def require_inside(self, trajectory: Trajectory, whose: str = "the guard's fence") -> None:
        """Refuse a trajectory, NED relative to the takeoff point, that the fence would cut.

        Raises:
            InputError: it leaves the fence; names where, and by how much.
        """
        positions = trajectory.sample(instants(trajectory)).position
        low, high = self.corners()
        beyond = np.maximum(low - positions.min(axis=0), positions.max(axis=0) - high)
        if (beyond > ROUNDING_M).any():
            axis = int(beyond.argmax())
            name = ("north_m", "east_m", "altitude_m")[axis]
            raise InputError(
                f"{trajectory.name} leaves the fence by {beyond[axis]:.2f} m ({name} "
                f"{list(getattr(self, name))}): move it, make it smaller, or widen the fence (--guard FILE)"
            )
        super().require_inside(trajectory, whose)


def keep_inside(position: Vec3, home: Vec3, fence: Fence, vehicle_fence: Areas, otherwise: Vec3) -> Vec3:
    """The position nearest to `position` that lies inside both fences, which are around `home` (NED, m).

    Where several borders meet and no point of one alone will do: north and east of `otherwise`, which
    should be inside.
    """
    lowest, highest = zip(fence.corners(), vehicle_fence.corners(), strict=True)
    low, high = home + np.maximum(*lowest), home + np.minimum(*highest)
    boxed: Vec3 = np.clip(position, low, high)
    place = boxed[:2] - home[:2]
    if _is_allowed(place, fence, vehicle_fence):
        return boxed
    borders = home[:2] + np.concatenate([fence.border(place), vehicle_fence.border(place)])
    places = [
        point
        for point in np.clip(borders, low[:2], high[:2])
        if _is_allowed(point - home[:2], fence, vehicle_fence)
    ]
    last = np.clip(otherwise[:2], low[:2], high[:2])
    nearest = min(places, key=lambda point: float(np.linalg.norm(point - boxed[:2])), default=last)
    return np.array([*nearest, boxed[2]])


def _is_allowed(place: Place, fence: Fence, vehicle_fence: Areas) -> bool:
    return fence.beyond_m(place) <= ROUNDING_M and vehicle_fence.beyond_m(place) <= ROUNDING_M
