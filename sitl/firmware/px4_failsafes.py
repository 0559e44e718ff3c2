"""What PX4 does when the setpoints or the ground station are gone (its commander/failsafe/failsafe.cpp)."""

import math
from collections.abc import Mapping
from enum import Enum, auto
from typing import TypeAlias

from sitl.firmware.interface import Mode
from sitl.firmware.px4_parameters import Px4Parameters


class Stop(Enum):
    """An end of the flight that is no mode."""

    TERMINATE = auto()
    DISARM = auto()


Action: TypeAlias = Mode | Stop

OFFBOARD_LOST: Mapping[int, Action] = {
    0: Mode.POSCTL,
    1: Mode.ALTCTL,
    2: Mode.STABILIZE,
    3: Mode.RTL,
    4: Mode.LAND,
    5: Mode.HOLD,
    6: Stop.TERMINATE,
    7: Stop.DISARM,
}
"""COM_OBL_RC_ACT."""

_LINK_LOST: Mapping[int, Action] = {
    1: Mode.HOLD,
    2: Mode.RTL,
    3: Mode.LAND,
    5: Stop.TERMINATE,
    6: Stop.DISARM,
}
"""NAV_DLL_ACT."""


class GroundLink:
    """Whether the ground station is heard, and what to do when it no longer is."""

    def __init__(self) -> None:
        self._heard_s = -math.inf
        self._lost_s: float | None = None
        self._done = False

    def hear(self, time_s: float) -> None:
        """A heartbeat came at this time (s)."""
        self._heard_s = time_s

    def dismiss(self) -> None:
        """Somebody has chosen a mode: this loss has no further consequence."""
        self._done = self._lost_s is not None

    def is_lost(self, parameters: Px4Parameters, time_s: float) -> bool:
        """Whether a failsafe counts the link as lost."""
        return parameters.NAV_DLL_ACT != 0 and time_s - self._heard_s > parameters.COM_DL_LOSS_T

    def update(self, parameters: Px4Parameters, mode: Mode, time_s: float) -> Action | None:
        """What has to be done now: a hold at first, which leaves COM_FAIL_ACT_T to think, then the rest."""
        if not self.is_lost(parameters, time_s):
            self._lost_s, self._done = None, False
            return None
        action = _LINK_LOST[parameters.NAV_DLL_ACT]
        if self._done or mode is Mode.LAND:
            return None
        if self._lost_s is None:
            self._lost_s = time_s
            self._done = action is Mode.HOLD or isinstance(action, Stop)
            return action if self._done else Mode.HOLD
        if time_s - self._lost_s < parameters.COM_FAIL_ACT_T:
            return None
        self._done = True
        return action


class BatteryWatch:
    """Which of the thresholds the charge has fallen below: 1 low, 2 critical, 3 nearly empty."""

    def __init__(self) -> None:
        self.level = 0

    def falls(self, parameters: Px4Parameters, remaining: float) -> bool:
        """Whether the charge (0 to 1) is below another threshold since the last look."""
        p, before = parameters, self.level
        thresholds = (p.BAT_LOW_THR, p.BAT_CRIT_THR, p.BAT_EMERGEN_THR)
        self.level = max(before, sum(remaining < threshold for threshold in thresholds))
        return self.level > before

    @property
    def action(self) -> Mode | None:
        """Return when critical, land when nearly empty (COM_LOW_BAT_ACT 3)."""
        return (None, None, Mode.RTL, Mode.LAND)[self.level]
