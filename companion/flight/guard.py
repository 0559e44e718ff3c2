"""The guard: the last thing before the wire, which may overrule every reference.

Pure functions over arrays; what they change, they name, so that it can be counted and shown.
"""

import math
from dataclasses import dataclass, field
from enum import StrEnum

import numpy as np
from pydantic import BaseModel, ConfigDict, Field, PositiveFloat

from companion.arrays import Vec3
from companion.errors import InputError
from companion.flight.fence import Fence, keep_inside
from companion.flight.reference import Correction, Reference
from companion.flight.vehicle_fence import NO_FENCE, VehicleFence
from companion.flight.watchdogs import Watchdogs
from companion.state import VehicleState
from companion.trajectory.limits import peaks_of
from companion.trajectory.trajectory import Trajectory

_LONGEST_STEP_S = 0.2
"""Between two setpoints that are farther apart, no more may change than in this time."""


class Clip(StrEnum):
    """What the guard changed in a reference."""

    CORRECTION = "correction limited"
    SPEED = "speed limited"
    ACCELERATION = "acceleration limited"
    JERK = "jerk limited"
    DISTANCE = "setpoint kept near the vehicle"
    FENCE = "setpoint kept inside the fence"
    NOT_FINITE = "not finite: baseline sent"


class GuardLimits(BaseModel):
    """How far a reference may go."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    correction_m: PositiveFloat = 1.0
    """|u2|: the online correction is scaled down to this length."""
    correction_m_s: PositiveFloat = 10.0
    """The same of its velocity."""
    speed_m_s: PositiveFloat = 20.0
    """Of the velocity setpoint."""
    acceleration_m_s2: PositiveFloat = 20.0
    """Of the acceleration setpoint."""
    velocity_change_m_s2: PositiveFloat = 400.0
    """How fast the velocity setpoint may change: by 8 m/s at 50 Hz. Corrections change it in steps."""
    jerk_m_s3: PositiveFloat = 500.0
    """How fast the acceleration setpoint may change."""
    setpoint_distance_m: PositiveFloat = 2.0
    """From the vehicle to the position setpoint."""
    tracking_error_m: PositiveFloat = 3.0
    """Beyond this the flight ends in a hold."""
    max_distance_m: PositiveFloat = 500.0
    """From the vehicle to any waypoint of a plan: one that leads farther is refused."""
    fence: Fence = Field(default_factory=Fence)
    watchdogs: Watchdogs = Field(default_factory=Watchdogs)


def require_flyable(trajectory: Trajectory, limits: GuardLimits) -> None:
    """Refuse a trajectory, NED relative to the takeoff point, that the guard would have to clip.

    Raises:
        InputError: it leaves the fence, or its speed or acceleration is above the limit; says by how much.
    """
    limits.fence.require_inside(trajectory)
    peaks = peaks_of(trajectory)
    for name, peak in (("speed_m_s", peaks.speed_m_s), ("acceleration_m_s2", peaks.acceleration_m_s2)):
        limit = getattr(limits, name)
        if peak > limit:
            raise InputError(
                f"{trajectory.name} asks for {name} {peak:.1f}, and the guard lets {limit:g} pass: "
                "fly it more slowly, or allow more (--guard FILE)"
            )


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


@dataclass(frozen=True, slots=True, eq=False)
class Before:
    """The setpoint before: `reference` was sent at `time_s` (companion clock, s)."""

    time_s: float
    reference: Reference


def guard(
    u1: Reference,
    u2: Correction,
    plain: Reference,
    *,
    state: VehicleState,
    home: Vec3,
    limits: GuardLimits,
    vehicle_fence: VehicleFence = NO_FENCE,
    before: Before | None = None,
) -> Guarded:
    """What may be sent in place of u1 + u2.

    Args:
        u1: the reference before the online correction.
        u2: the online correction.
        plain: the baseline's reference, sent when the strategy's is not finite.
        state: where the vehicle is, at the instant of this setpoint.
        home: the takeoff point, NED (m): the fence is around it.
        limits: how far a reference may go.
        vehicle_fence: the vehicle's own.
        before: the setpoint before, from which this one may not differ too much.
    """
    clips: list[Clip] = []
    with np.errstate(over="ignore", invalid="ignore"):
        finite = u1.corrected(u2).is_finite()
    if not finite:
        u1, u2 = plain, Correction()
        clips.append(Clip.NOT_FINITE)
    limited = Correction(
        limit_length(u2.position, limits.correction_m), limit_length(u2.velocity, limits.correction_m_s)
    )
    if limited.position is not u2.position or limited.velocity is not u2.velocity:
        clips.append(Clip.CORRECTION)
    wanted = u1.corrected(limited)
    moved = _within_motion_limits(wanted, limits, before, state.time_s, clips)
    position = _within_reach(wanted.position, state.position, limits.setpoint_distance_m, clips)
    last = state.position if before is None else before.reference.position
    inside = keep_inside(position, home, limits.fence, vehicle_fence, last)
    if not np.array_equal(inside, position):
        clips.append(Clip.FENCE)
    return Guarded(Reference(inside, moved.velocity, moved.acceleration), limited, tuple(clips))


def _within_motion_limits(
    wanted: Reference, limits: GuardLimits, before: Before | None, time_s: float, clips: list[Clip]
) -> Reference:
    """Velocity and acceleration within their limits, and within reach of those before."""
    velocity = limit_length(wanted.velocity, limits.speed_m_s)
    if velocity is not wanted.velocity:
        clips.append(Clip.SPEED)
    still = np.zeros(3)
    asked = still if wanted.acceleration is None else wanted.acceleration
    acceleration = limit_length(asked, limits.acceleration_m_s2)
    clipped = acceleration is not asked
    jerked = acceleration
    if before is not None:
        step_s = min(max(time_s - before.time_s, 0.0), _LONGEST_STEP_S)
        was = before.reference
        slower = _near(velocity, was.velocity, limits.velocity_change_m_s2 * step_s)
        clipped = clipped or slower is not velocity
        velocity = slower
        last = still if was.acceleration is None else was.acceleration
        jerked = _near(acceleration, last, limits.jerk_m_s3 * step_s)
    if clipped:
        clips.append(Clip.ACCELERATION)
    if jerked is not acceleration:
        clips.append(Clip.JERK)
    is_sent = wanted.acceleration is not None or jerked is not acceleration
    return Reference(wanted.position, velocity, jerked if is_sent else None)


def _within_reach(position: Vec3, of: Vec3, distance_m: float, clips: list[Clip]) -> Vec3:
    reached = _near(position, of, distance_m)
    if reached is not position:
        clips.append(Clip.DISTANCE)
    return reached


def _near(vector: Vec3, other: Vec3, distance: float) -> Vec3:
    """The vector, or what lies that far from the other on the way to it."""
    offset = vector - other
    near = limit_length(offset, distance)
    return vector if near is offset else other + near
