"""The vehicle's own fence: areas, and how far its parameters let it go from where it took off."""

import math
from typing import TypeAlias

import numpy as np
from jaxtyping import Float
from pydantic import BaseModel, ConfigDict, FiniteFloat, NonNegativeFloat

from companion.arrays import Array, Vec3
from companion.errors import InputError
from companion.flight.fence import ROUNDING_M, Areas, Place, Places
from companion.flight.instants import instants
from companion.trajectory.trajectory import Trajectory

_Distances: TypeAlias = Float[Array, " n"]


class Bound(BaseModel):
    """A limit that one of the vehicle's parameters sets, from its takeoff point (m)."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    parameter: str
    value_m: FiniteFloat
    margin_m: NonNegativeFloat
    """How far inside it setpoints stay: a vehicle that only just crosses it does what a breach asks for."""

    def __str__(self) -> str:
        return f"{self.parameter} {self.value_m:g}"


class Bounds(BaseModel):
    """How far the vehicle's parameters let it go from where it took off; no bound is None."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    distance: Bound | None = None
    """On the ground."""
    ceiling: Bound | None = None
    floor: Bound | None = None

    @property
    def distance_m(self) -> float:
        """How far setpoints may be on the ground (m)."""
        return math.inf if self.distance is None else self.distance.value_m - self.distance.margin_m

    @property
    def altitude_m(self) -> tuple[float, float]:
        """How low and how high above the takeoff point they may be (m)."""
        floor, ceiling = self.floor, self.ceiling
        return (
            -math.inf if floor is None else floor.value_m + floor.margin_m,
            math.inf if ceiling is None else ceiling.value_m - ceiling.margin_m,
        )

    def __bool__(self) -> bool:
        return any((self.distance, self.ceiling, self.floor))

    def __str__(self) -> str:
        low_m, high_m = self.altitude_m
        told = (
            (self.distance, f"within {self.distance_m:g} m of the takeoff point"),
            (self.ceiling, f"at most {high_m:g} m above it"),
            (self.floor, f"at least {low_m:g} m above it"),
        )
        return ", ".join(f"{words} ({bound})" for bound, words in told if bound)

    def altitude_within(self, altitude_m: float) -> float:
        """The height above the takeoff point (m) that is nearest to `altitude_m`, and allowed."""
        low_m, high_m = self.altitude_m
        return min(max(altitude_m, low_m), high_m)

    def require_inside(self, trajectory: Trajectory) -> None:
        """Refuse a trajectory, NED relative to the takeoff point, that leads farther.

        Raises:
            InputError: names the parameter and its value, and says when, and by how much.
        """
        times_s = instants(trajectory)
        position = trajectory.sample(times_s).position
        low_m, high_m = self.altitude_m
        beyond: tuple[tuple[Bound | None, _Distances], ...] = (
            (self.distance, np.linalg.norm(position[:, :2], axis=1) - self.distance_m),
            (self.ceiling, -position[:, 2] - high_m),
            (self.floor, low_m + position[:, 2]),
        )
        for bound, beyond_m in beyond:
            worst = int(np.argmax(beyond_m))
            if bound is not None and beyond_m[worst] > ROUNDING_M:
                raise InputError(
                    f"{trajectory.name} is {beyond_m[worst]:.2f} m beyond what the vehicle's {bound} allows, "
                    f"which is kept {bound.margin_m:g} m away from, {times_s[worst]:.1f} s after its "
                    f"beginning: move it, make it smaller, or change {bound.parameter}"
                )


class VehicleFence(Areas):
    """The areas of a vehicle's own fence, and its bounds, which hold as well as the areas."""

    bounds: Bounds = Bounds()

    def beyond_m(self, place: Place) -> float:
        """How far it is from where the vehicle may be (m); not positive where it may."""
        return max(super().beyond_m(place), float(np.linalg.norm(place)) - self.bounds.distance_m)

    def border(self, place: Place) -> Places:
        """The points of all borders that may be nearest to it."""
        areas = super().border(place)
        away_m = float(np.linalg.norm(place))
        if self.bounds.distance is None or away_m == 0.0:
            return areas
        return np.concatenate([areas, place[None, :] * (self.bounds.distance_m / away_m)])

    def corners(self) -> tuple[Vec3, Vec3]:
        """Least and greatest NED position relative to the takeoff point (m)."""
        low_m, high_m = self.bounds.altitude_m
        return np.array([-np.inf, -np.inf, -high_m]), np.array([np.inf, np.inf, -low_m])

    def require_inside(self, trajectory: Trajectory, whose: str = "the vehicle's fence") -> None:
        """Refuse a trajectory, NED relative to the takeoff point, that leaves the bounds or the areas.

        Raises:
            InputError: it does; says when, and by how much.
        """
        self.bounds.require_inside(trajectory)
        super().require_inside(trajectory, whose)


NO_FENCE = VehicleFence()
