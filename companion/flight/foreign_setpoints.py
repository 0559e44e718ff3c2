"""Whose setpoints the vehicle follows: POSITION_TARGET_LOCAL_NED against what was sent.

PX4 tells the position of a setpoint as it came; ArduPilot moves it on with its velocity until the next comes.
Another program that sends to the same vehicle shows only here: its setpoints and ours take turns.
"""

import math
from collections import deque

from companion.arrays import Vec3

_SENT_KEPT_S = 1.0
"""So long a setpoint may take to the vehicle, and what it tells of it back."""
_OURS_M = 0.5
_TOLD_KEPT = 20
"""One or two seconds of them."""


class ForeignSetpoints:
    """Finds out which of the setpoints that the vehicle tells of were not sent by us."""

    def __init__(self) -> None:
        self._sent: deque[tuple[float, Vec3]] = deque()
        self._told: Vec3 | None = None
        self._foreign: deque[bool] = deque(maxlen=_TOLD_KEPT)

    def sent(self, time_s: float, position: Vec3) -> None:
        """A setpoint was sent at `time_s` (companion clock, s), to `position` (NED, m)."""
        self._sent.append((time_s, position))
        while self._sent[0][0] < time_s - _SENT_KEPT_S:
            self._sent.popleft()

    def share(self, told: Vec3 | None) -> float:
        """Of the last twenty that it told of, those that were not ours (0 to 1).

        `told` is the newest (NED, m), the same object until another comes. NaN before there are twenty.
        """
        if told is not None and told is not self._told:
            self._told = told
            self._foreign.append(all(math.dist(told, position) > _OURS_M for _, position in self._sent))
        return sum(self._foreign) / _TOLD_KEPT if len(self._foreign) == _TOLD_KEPT else math.nan
