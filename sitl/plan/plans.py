"""The plans on board: what is uploaded, and what the firmware flies by."""

from collections.abc import Callable

import numpy as np

from sitl.arrays import Vec3
from sitl.plan.items import Item, Plan, PlanKind
from sitl.plan.mission import Mission


class Plans:
    """Mission, fence and rally points, and home.

    Args:
        home: where the vehicle is at first, NED (m).
        mission: flies the mission plan.
        changed: told which plan has just been replaced.

    Attributes:
        home: what altitudes count from and a return ends at, NED (m).
        mission: how far the mission is.
    """

    def __init__(self, home: Vec3, mission: Mission, changed: Callable[[PlanKind], None]) -> None:
        self.home = home
        self.mission = mission
        self._changed = changed
        self._others = {PlanKind.FENCE: Plan(), PlanKind.RALLY: Plan()}

    def __getitem__(self, kind: PlanKind) -> Plan:
        return self.mission.plan if kind is PlanKind.MISSION else self._others[kind]

    def replace(self, kind: PlanKind, items: tuple[Item, ...], current: int = 0) -> None:
        """Another plan instead of the present one; a mission begins at item `current`."""
        if kind is PlanKind.MISSION:
            self.mission.load(Plan(items), current)
        else:
            self._others[kind] = Plan(items)
        self._changed(kind)


def nowhere() -> Vec3:
    """The origin of the map, NED (m)."""
    return np.zeros(3)
