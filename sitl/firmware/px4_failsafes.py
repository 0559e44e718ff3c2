"""What PX4 does without setpoints, beyond its fence and with a low battery (`failsafe/failsafe.cpp`)."""

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

BREACH_ACTIONS: Mapping[int, Action] = {
    2: Mode.HOLD,
    3: Mode.RTL,
    4: Stop.TERMINATE,
    5: Mode.LAND,
}
"""GF_ACTION."""

_LOW_BATTERY: Mapping[int, tuple[Mode | None, ...]] = {
    0: (None, None, None, None),
    2: (None, None, Mode.LAND, Mode.LAND),
    3: (None, None, Mode.RTL, Mode.LAND),
}
"""By COM_LOW_BAT_ACT and level."""


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

    def action(self, parameters: Px4Parameters) -> Mode | None:
        """What COM_LOW_BAT_ACT asks for at this level."""
        return _LOW_BATTERY[parameters.COM_LOW_BAT_ACT][self.level]
