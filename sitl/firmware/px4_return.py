"""Where PX4's Return goes, and how high (`rtl.cpp` of its navigator)."""

import math

import numpy as np

from sitl.arrays import Vec3
from sitl.firmware.px4_parameters import Px4Parameters
from sitl.plan.items import Command, PlanKind
from sitl.plan.places import local_place
from sitl.plan.plans import Plans


def return_place(parameters: Px4Parameters, plans: Plans, here: Vec3) -> Vec3:
    """Home, a rally point or where the mission lands, as RTL_TYPE has it; NED (m)."""
    home = plans.home
    rally = [local_place(item, home) for item in plans[PlanKind.RALLY].items]
    mission = plans[PlanKind.MISSION].items
    landing = [local_place(item, home) for item in mission if item.command == Command.NAV_LAND]
    match parameters.RTL_TYPE:
        case 0:
            candidates = [home, *rally]
        case 1:
            candidates = [*rally, *landing[:1]] or [home]
        case 3:
            candidates = [home, *rally, *landing[:1]]
        case 5:
            candidates = rally or [home]
        case _:
            candidates = landing[:1] or [home]
    return min(candidates, key=lambda place: float(np.linalg.norm(place[:2] - here[:2])))


def return_height(parameters: Px4Parameters, place: Vec3, here: Vec3) -> float:
    """Height above `place` (m) at which to fly there; near it only up to the cone of RTL_CONE_ANG.

    RTL::calculate_return_alt_from_cone_half_angle.
    """
    p = parameters
    now, away = float(place[2] - here[2]), float(np.linalg.norm(here[:2] - place[:2]))
    height = p.RTL_RETURN_ALT
    if p.RTL_CONE_ANG:
        if away <= p.NAV_ACC_RAD:
            height = 2.0 * away
        else:
            if away <= p.RTL_MIN_DIST:
                height = min(height, away / math.tan(math.radians(min(p.RTL_CONE_ANG, 89))))
            height = max(height, 2.0 * p.NAV_ACC_RAD)
    return max(now, height)
