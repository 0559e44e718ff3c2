"""From waypoints to a trajectory: straight from one to the next, corners cut no wider than allowed.

Position, velocity, acceleration and jerk are continuous; limits hold everywhere. How it is timed: `route`.
"""

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from companion.errors import InputError
from companion.trajectory.limits import Limits, peaks_of, stretches
from companion.trajectory.route import Route, TimedStep, Waypoint
from companion.trajectory.trajectory import Trajectory, quintic_through
from companion.trajectory.velocity_step import progress

LONGEST_S = 7200.0
_SAME_M = 1e-3
"""Nearer to each other than this, two waypoints are one."""
_KNOTS_S = 0.05
_RESERVE = 0.98
"""Share of acceleration and jerk to plan with: between knots a trajectory is not quite what was planned."""
_REST_S = 1.0


def trajectory_through(name: str, waypoints: Sequence[Waypoint], limits: Limits) -> Trajectory:
    """The motion along `waypoints`, from rest at the first to rest at the last, as fast as `limits` allow.

    A speed in `limits` counts beside those of the waypoints: the lower one holds.

    Raises:
        InputError: there is no waypoint, one makes no sense, or all takes longer than `LONGEST_S`.
    """
    _require_sensible(waypoints)
    allowed = limits.peaks(usual_speed_m_s=math.inf)
    planned = replace(
        allowed,
        acceleration_m_s2=_RESERVE * allowed.acceleration_m_s2,
        vertical_acceleration_m_s2=_RESERVE * allowed.vertical_acceleration_m_s2,
        jerk_m_s3=_RESERVE * allowed.jerk_m_s3,
    )
    steps, duration_s = Route(_merged(waypoints), planned).schedule()
    if duration_s > LONGEST_S:
        raise InputError(
            f"it would take {duration_s:.0f} s within the limits, more than {LONGEST_S:.0f} s: split it, "
            "or allow more speed"
        )
    if not steps:
        position = np.stack([waypoints[0].position] * 2)
        still = np.zeros_like(position)
        return quintic_through(name, max(duration_s, _REST_S), position, still, still)
    trajectory = _sampled(name, steps, duration_s)
    return trajectory.stretched(max(1.0, *stretches(peaks_of(trajectory), allowed).values()))


def _sampled(name: str, steps: Sequence[TimedStep], duration_s: float) -> Trajectory:
    """The trajectory that makes these steps."""
    segments = math.ceil(duration_s / _KNOTS_S)
    knots_s = np.linspace(0.0, duration_s, segments + 1)
    starts_s = np.array([step.start_s for step in steps])
    newest = np.maximum(np.searchsorted(starts_s, knots_s, side="right") - 1, 0)
    elapsed_s = knots_s - starts_s[newest]
    ramp_s, spread_s = np.array([(step.shape.ramp_s, step.shape.spread_s) for step in steps])[newest].T
    distance, speed, acceleration = (part[:, None] for part in progress(elapsed_s, ramp_s, spread_s))
    position = np.stack([step.position for step in steps])[newest]
    velocity = np.stack([step.velocity for step in steps])[newest]
    change = np.stack([step.change for step in steps])[newest]
    return quintic_through(
        name,
        duration_s / segments,
        position + velocity * elapsed_s[:, None] + change * distance,
        velocity + change * speed,
        change * acceleration,
    )


def _merged(waypoints: Sequence[Waypoint]) -> list[Waypoint]:
    """The waypoints without those that are where the last one was; their holds add up."""
    merged = [waypoints[0]]
    for waypoint in waypoints[1:]:
        last = merged[-1]
        if math.dist(last.position, waypoint.position) > _SAME_M:
            merged.append(waypoint)
        else:
            hold_s, within_m = last.hold_s + waypoint.hold_s, min(last.within_m, waypoint.within_m)
            merged[-1] = replace(last, hold_s=hold_s, within_m=within_m)
    return merged


def _require_sensible(waypoints: Sequence[Waypoint]) -> None:
    if not waypoints:
        raise InputError("there is no waypoint to fly to")
    for number, waypoint in enumerate(waypoints, start=1):
        if not np.isfinite(waypoint.position).all():
            raise InputError(f"waypoint {number}: its position is not finite")
        if not 0.0 < waypoint.speed_m_s < math.inf:
            raise InputError(f"waypoint {number}: speed {waypoint.speed_m_s} m/s: give a positive number")
        for what in ("within_m", "hold_s"):
            if not 0.0 <= getattr(waypoint, what) < math.inf:
                raise InputError(f"waypoint {number}: {what} is {getattr(waypoint, what)}: give 0 or more")
