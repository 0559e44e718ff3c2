"""Where ArduPilot's RTL goes, and how high (`mode_rtl.cpp`, `AP_Rally.cpp`); and what its fence forbids."""

import math
from enum import IntFlag

import numpy as np

from sitl.arrays import Vec3
from sitl.firmware.ardupilot_parameters import ArduPilotParameters
from sitl.geodesy import ARDUPILOT_EARTH_M
from sitl.plan.fence import FenceError, Limits, boundary
from sitl.plan.items import Plan, PlanKind
from sitl.plan.places import local_place
from sitl.plan.plans import Plans

_LEAST_HEIGHT_M = 0.3
_LEAST_SLOPE = 0.5
"""RTL_ALT_MIN and RTL_MIN_CONE_SLOPE in ArduCopter/config.h."""


def return_place(parameters: ArduPilotParameters, plans: Plans, here: Vec3) -> Vec3:
    """The nearest rally point within RALLY_LIMIT_KM, or home (if nearer, and RALLY_INCL_HOME).

    NED (m); a rally point's height is the least at which to return.
    """
    home = plans.home
    rally = [local_place(item, home, ARDUPILOT_EARTH_M) for item in plans[PlanKind.RALLY].items]
    limit_m = 1e3 * parameters.RALLY_LIMIT_KM
    near = [place for place in rally if limit_m == 0.0 or _distance(place, here) <= limit_m]
    candidates = [home, *near] if parameters.RALLY_INCL_HOME or not near else near
    return min(candidates, key=lambda candidate: _distance(candidate, here))


def _distance(place: Vec3, here: Vec3) -> float:
    return float(np.linalg.norm(place[:2] - here[:2]))


def return_height(parameters: ArduPilotParameters, place: Vec3, here: Vec3, home: Vec3) -> float:
    """Height above home (m) at which to fly to `place`, never lower than now.

    RTL_ALT, but within the cone of RTL_CONE_SLOPE over the place, and FENCE_MARGIN below a fence
    (`ModeRTL::compute_return_target`).
    """
    p = parameters
    now = float(home[2] - here[2])
    least = max(_LEAST_HEIGHT_M, now + 0.01 * p.RTL_CLIMB_MIN)
    height = max(float(home[2] - place[2]), 0.01 * p.RTL_ALT, least)
    if p.RTL_CONE_SLOPE >= _LEAST_SLOPE:
        height = min(height, max(p.RTL_CONE_SLOPE * _distance(place, here), least))
    if p.FENCE_ENABLE and FenceType.HEIGHT in FenceType(p.FENCE_TYPE):
        height = min(height, p.FENCE_ALT_MAX - p.FENCE_MARGIN)
    return max(height, now)


class FenceType(IntFlag):
    """Bits of FENCE_TYPE."""

    HEIGHT = 1
    DISTANCE = 2
    BOUNDARY = 4
    LEAST_HEIGHT = 8


def fence_limits(parameters: ArduPilotParameters, fence: Plan) -> Limits | None:
    """What the fence forbids; None while it is not enabled."""
    p = parameters
    if not p.FENCE_ENABLE:
        return None
    kinds = FenceType(p.FENCE_TYPE)
    try:
        areas = boundary(fence.items if FenceType.BOUNDARY in kinds else (), ARDUPILOT_EARTH_M)
    except FenceError:
        areas = boundary(())
    return Limits(
        distance=p.FENCE_RADIUS if FenceType.DISTANCE in kinds else math.inf,
        height=p.FENCE_ALT_MAX if FenceType.HEIGHT in kinds else math.inf,
        least_height=p.FENCE_ALT_MIN if FenceType.LEAST_HEIGHT in kinds else -math.inf,
        boundary=areas,
    )
