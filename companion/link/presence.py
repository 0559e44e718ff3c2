"""Whether the vehicle is there: how long it has been silent, and who wants to know when that changes."""

import asyncio
import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import TypeAlias

from companion import clock

LOST_AFTER_S = 3.0
"""A vehicle that has been silent for this long counts as lost (as in MAVSDK)."""


@dataclass(frozen=True, slots=True)
class LinkChange:
    """The vehicle fell silent, or is heard again.

    Attributes:
        time_s: when that was noticed (companion clock, s).
        lost: whether it is silent now.
        silence_s: for how long it has been, or had been, silent (s).
    """

    time_s: float
    lost: bool
    silence_s: float


LinkHandler: TypeAlias = Callable[[LinkChange], None]


class Presence:
    """Of the vehicle on the link; told of each frame that comes from its autopilot.

    Attributes:
        lost: whether it has been silent for `LOST_AFTER_S` or longer; False until it is first heard.
        losses: how often that happened.
    """

    def __init__(self) -> None:
        self.lost = False
        self.losses = 0
        self._heard_s = -math.inf
        self._heard = asyncio.Event()
        self._handlers: tuple[LinkHandler, ...] = ()

    @property
    def silence_s(self) -> float:
        """Time since anything was heard of the vehicle (s); infinite before."""
        return clock.now() - self._heard_s

    def subscribe(self, handler: LinkHandler) -> Callable[[], None]:
        """Call `handler` when the vehicle is lost and when it is back; returns what ends that."""
        self._handlers += (handler,)

        def unsubscribe() -> None:
            self._handlers = tuple(other for other in self._handlers if other is not handler)

        return unsubscribe

    def heard(self) -> None:
        """Something came from the vehicle, now."""
        silence_s, self._heard_s = self.silence_s, clock.now()
        self._heard.set()
        if self.lost:
            self.lost = False
            self._tell(silence_s)

    async def watch(self) -> None:
        """Notice when the vehicle falls silent, until cancelled."""
        while True:
            await self._heard.wait()
            heard_s = self._heard_s
            await clock.sleep_until(heard_s + LOST_AFTER_S)
            if heard_s == self._heard_s:
                self.lost = True
                self.losses += 1
                self._heard.clear()
                self._tell(self.silence_s)

    def _tell(self, silence_s: float) -> None:
        change = LinkChange(clock.now(), self.lost, silence_s)
        for handler in self._handlers:
            handler(change)
