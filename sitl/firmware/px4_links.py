"""What PX4 does when its ground station or its pilot is gone (its commander's `failsafe/failsafe.cpp`)."""

import math
from collections.abc import Mapping

from sitl.firmware.interface import Mode
from sitl.firmware.pilot import Pilot
from sitl.firmware.px4_failsafes import Action, Stop
from sitl.firmware.px4_parameters import Px4Parameters

_LINK_LOST: Mapping[int, Action] = {
    1: Mode.HOLD,
    2: Mode.RTL,
    3: Mode.LAND,
    5: Stop.TERMINATE,
    6: Stop.DISARM,
}
"""NAV_DLL_ACT and NAV_RCL_ACT."""

_EXCEPTIONS: Mapping[Mode, int] = {
    Mode.MISSION: 1,
    Mode.HOLD: 2,
    Mode.TAKEOFF: 2,
    Mode.LAND: 2,
    Mode.RTL: 2,
    Mode.OFFBOARD: 4,
}
"""Bits of COM_RCL_EXCEPT."""
_OVERRIDES_AUTOMATIC, _OVERRIDES_OFFBOARD = 1, 2
"""Bits of COM_RC_OVERRIDE."""
_NO_PILOT = 4
"""COM_RC_IN_MODE."""


def may_be_piloted(parameters: Px4Parameters) -> bool:
    """Whether sticks mean anything."""
    return parameters.COM_RC_IN_MODE != _NO_PILOT


def may_override(parameters: Px4Parameters, mode: Mode) -> bool:
    """Whether sticks that are moved take a mode over."""
    bit = _OVERRIDES_OFFBOARD if mode is Mode.OFFBOARD else _OVERRIDES_AUTOMATIC
    return bool(parameters.COM_RC_OVERRIDE & bit)


class Loss:
    """What follows from one loss: a hold, which leaves COM_FAIL_ACT_T to think, then what is asked for."""

    def __init__(self) -> None:
        self._lost_s: float | None = None
        self._done = False

    def dismiss(self) -> None:
        """Somebody has chosen a mode: this loss has no further consequence."""
        self._done = self._lost_s is not None

    def update(self, action: Action | None, delay_s: float, time_s: float) -> Action | None:
        """What has to be done now; `action` is what the loss asks for, None while nothing is lost."""
        if action is None:
            self._lost_s, self._done = None, False
        elif self._lost_s is None:
            self._lost_s = time_s
            self._done = delay_s == 0.0 or action is Mode.HOLD or isinstance(action, Stop)
            return action if self._done else Mode.HOLD
        elif not self._done and time_s - self._lost_s >= delay_s:
            self._done = True
            return action
        return None


class Links:
    """Whether ground station and pilot are heard, and what to do when they no longer are."""

    def __init__(self) -> None:
        self._ground_heard_s = -math.inf
        self._ground, self._pilot = Loss(), Loss()

    def hear_ground(self, time_s: float) -> None:
        """A heartbeat of a ground station came at this time (s)."""
        self._ground_heard_s = time_s

    def dismiss(self) -> None:
        """Somebody has chosen a mode: no loss has further consequences."""
        self._ground.dismiss()
        self._pilot.dismiss()

    def misses_ground(self, p: Px4Parameters, time_s: float) -> bool:
        """Whether the ground station is gone, and NAV_DLL_ACT cares."""
        return p.NAV_DLL_ACT != 0 and time_s - self._ground_heard_s > p.COM_DL_LOSS_T

    def update(
        self, p: Px4Parameters, mode: Mode, pilot: Pilot, armed_s: float, time_s: float
    ) -> tuple[Action, str] | None:
        """What has to be done now, and why; a pilot counts who was there at `armed_s` (s) or later."""
        action = _LINK_LOST[p.NAV_DLL_ACT] if self.misses_ground(p, time_s) else None
        now = self._ground.update(action, p.COM_FAIL_ACT_T, time_s)
        if now is not None:
            return now, "connection to ground station lost"
        ignored = p.COM_RCL_EXCEPT & _EXCEPTIONS.get(mode, 0) or not may_be_piloted(p)
        is_lost = not ignored and pilot.is_lost(armed_s - p.COM_RC_LOSS_T, p.COM_RC_LOSS_T, time_s)
        now = self._pilot.update(_LINK_LOST[p.NAV_RCL_ACT] if is_lost else None, p.COM_FAIL_ACT_T, time_s)
        return None if now is None else (now, "manual control lost")
