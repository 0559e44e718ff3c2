"""The guard: the last thing before the wire, which may overrule every reference.

Pure functions over arrays; what they change, they name, so that it can be counted and shown.
"""

import math
from dataclasses import dataclass, field
from enum import StrEnum

import numpy as np
from pydantic import BaseModel, ConfigDict, Field, FiniteFloat, PositiveFloat, model_validator

from companion.arrays import Vec3, Vec3s
from companion.errors import InputError
from companion.flight.reference import Correction, Reference
from companion.state import VehicleState
from companion.trajectory.trajectory import Trajectory

MARGIN_M = 5.0
"""A fence around a path leaves it this much room: more than the tracking error that ends a flight."""
_LOOK_EVERY_S = 0.02
_ROUNDING_M = 1e-6


class Clip(StrEnum):
    """What the guard changed in a reference."""

    CORRECTION = "correction limited"
    DISTANCE = "setpoint kept near the vehicle"
    FENCE = "setpoint kept inside the fence"
    NOT_FINITE = "not finite: baseline sent"


class Fence(BaseModel):
    """A box around the takeoff point that no setpoint leaves; north, east and altitude in metres."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    north_m: tuple[FiniteFloat, FiniteFloat] = (-50.0, 50.0)
    east_m: tuple[FiniteFloat, FiniteFloat] = (-50.0, 50.0)
    altitude_m: tuple[FiniteFloat, FiniteFloat] = (0.5, 50.0)
    """Floor and ceiling above the takeoff point."""

    @model_validator(mode="after")
    def _low_before_high(self) -> "Fence":
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
        """Least and greatest NED position relative to the takeoff point (m)."""
        low = np.array([self.north_m[0], self.east_m[0], -self.altitude_m[1]])
        high = np.array([self.north_m[1], self.east_m[1], -self.altitude_m[0]])
        return low, high

    def require_inside(self, trajectory: Trajectory) -> None:
        """Refuse a trajectory, NED relative to the takeoff point, that the fence would cut.

        Raises:
            InputError: it leaves the fence; names where, and by how much.
        """
        positions = trajectory.sample(np.arange(0.0, trajectory.duration_s, _LOOK_EVERY_S)).position
        low, high = self.corners()
        beyond = np.maximum(low - positions.min(axis=0), positions.max(axis=0) - high)
        if (beyond > _ROUNDING_M).any():
            axis = int(beyond.argmax())
            name = ("north_m", "east_m", "altitude_m")[axis]
            raise InputError(
                f"{trajectory.name} leaves the fence by {beyond[axis]:.2f} m ({name} "
                f"{list(getattr(self, name))}): move it, make it smaller, or widen the fence (--guard FILE)"
            )


class GuardLimits(BaseModel):
    """How far a reference may go."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    correction_m: PositiveFloat = 1.0
    """|u2|: the online correction is scaled down to this length."""
    setpoint_distance_m: PositiveFloat = 2.0
    """From the vehicle to the position setpoint."""
    tracking_error_m: PositiveFloat = 3.0
    """Beyond this the flight ends in a hold."""
    state_age_s: PositiveFloat = 0.5
    """Older telemetry than this ends the flight in a hold."""
    max_distance_m: PositiveFloat = 500.0
    """From the vehicle to any waypoint of a plan: one that leads farther is refused."""
    fence: Fence = Field(default_factory=Fence)


@dataclass(frozen=True, slots=True, eq=False)
class Guarded:
    """A reference that may be sent, the correction left in it, and what had to be changed for that."""

    reference: Reference
    correction: Correction
    clips: tuple[Clip, ...] = field(default=())


def limit_length(vector: Vec3, length: float) -> Vec3:
    """The vector scaled down to at most `length`; its direction is kept."""
    norm = math.hypot(*vector)
    return vector if norm <= length else vector * (length / norm)


def guard(
    u1: Reference,
    u2: Correction,
    plain: Reference,
    *,
    state: VehicleState,
    home: Vec3,
    limits: GuardLimits,
) -> Guarded:
    """What may be sent in place of u1 + u2.

    Args:
        u1: the reference before the online correction.
        u2: the online correction.
        plain: the baseline's reference, sent when the strategy's is not finite.
        state: where the vehicle is.
        home: the takeoff point, NED (m): the fence is around it.
        limits: how far a reference may go.
    """
    clips: list[Clip] = []
    with np.errstate(over="ignore", invalid="ignore"):
        finite = u1.corrected(u2).is_finite()
    if not finite:
        u1, u2 = plain, Correction()
        clips.append(Clip.NOT_FINITE)
    limited = Correction(limit_length(u2.position, limits.correction_m), u2.velocity)
    if limited.position is not u2.position:
        clips.append(Clip.CORRECTION)
    wanted = u1.corrected(limited)
    offset = wanted.position - state.position
    near = limit_length(offset, limits.setpoint_distance_m)
    position = wanted.position if near is offset else state.position + near
    if near is not offset:
        clips.append(Clip.DISTANCE)
    low, high = limits.fence.corners()
    inside = np.clip(position, home + low, home + high)
    if not np.array_equal(inside, position):
        clips.append(Clip.FENCE)
    return Guarded(Reference(inside, wanted.velocity, wanted.acceleration), limited, tuple(clips))
