"""What would keep a plan's mission from being flown, found without flying it."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from companion.link.dialect import mavlink
from companion.mission.boundaries import areas_of
from companion.mission.commands import FLOWN_TO
from companion.mission.items import Fence, Frame, MissionItem, Plan
from companion.mission.site import Site

_OF_FENCE_AND_RALLY = range(mavlink.MAV_CMD_NAV_FENCE_RETURN_POINT, mavlink.MAV_CMD_NAV_RALLY_POINT + 1)
_FROM_GROUND = (mavlink.MAV_CMD_NAV_TAKEOFF, mavlink.MAV_CMD_NAV_VTOL_TAKEOFF)
_TO_GROUND = (mavlink.MAV_CMD_NAV_LAND, mavlink.MAV_CMD_NAV_VTOL_LAND)


@dataclass(frozen=True, slots=True)
class Findings:
    """What is to be said of a plan.

    Attributes:
        faults: why it cannot be flown.
        remarks: what may not be meant.
    """

    faults: tuple[str, ...]
    remarks: tuple[str, ...] = ()


def check_plan(plan: Plan) -> Findings:
    """Look at each item of the plan's mission by itself."""
    return Findings(tuple(_faults(plan.mission)), tuple(_remarks(plan)))


def check_places(plan: Plan, site: Site, fence: Fence, whose: str, max_distance_m: float) -> Findings:
    """Look at where each item of the plan's mission leads.

    Args:
        plan: what is to be flown.
        site: where the vehicle takes off.
        fence: where it may be.
        whose: fence that is, for the messages: "plan" or "vehicle".
        max_distance_m: no place may be farther from takeoff (m).
    """
    faults, areas = [], areas_of(fence, site)
    for index, item in enumerate(plan.mission):
        if item.command not in FLOWN_TO or item.coordinates is None:
            continue
        offset = site.horizontal(*item.coordinates)
        away_m = float(np.hypot(*offset))
        if away_m > max_distance_m:
            faults.append(
                f"item {index}: {item.name} is {away_m:.0f} m from takeoff, more than {max_distance_m:g} m"
            )
        beyond_m = areas.beyond_m(offset)
        if beyond_m > 0.0:
            faults.append(f"item {index}: {item.name} is {beyond_m:.1f} m beyond the {whose}'s fence")
    return Findings(tuple(faults))


def _faults(mission: Sequence[MissionItem]) -> Iterator[str]:
    if not mission:
        yield "there are no items"
    for index, item in enumerate(mission):
        if item.command in _OF_FENCE_AND_RALLY:
            yield f"item {index}: {item.name} belongs in a fence or in rally points, not in a mission"
        elif item.command in _FROM_GROUND and item.frame is not Frame.GLOBAL and not (item.z or 0.0) > 0.0:
            yield f"item {index}: {item.name} needs a positive altitude"
        elif item.has_place and item.command not in _TO_GROUND and item.z is None:
            yield f"item {index}: {item.name} has no altitude"


def _remarks(plan: Plan) -> Iterator[str]:
    flown_to = [item for item in plan.mission if item.command in FLOWN_TO]
    if flown_to and flown_to[0].command not in _FROM_GROUND:
        yield "it does not begin with a takeoff: the vehicle must be in the air already"
    for index, item in enumerate(plan.mission):
        below = item.frame is Frame.ABOVE_HOME and (item.z or 0.0) < 0.0
        if plan.home is not None and item.frame is Frame.GLOBAL and item.z is not None:
            below = item.z < plan.home.altitude_m
        if item.command in FLOWN_TO and below:
            yield f"item {index}: {item.name} is below home"
