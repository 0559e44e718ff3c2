"""Many requests at once over a link that loses some: a bounded window, and repeats in time.

How long an answer may take is learnt from those that came (RFC 6298); how many requests may be under way
grows with each answer and halves with a loss (as in RFC 5681), so that a slow link is not flooded.
"""

import asyncio
from collections import deque
from collections.abc import Callable, Hashable, Iterable
from dataclasses import dataclass
from typing import Generic, TypeVar

from companion import clock

K = TypeVar("K", bound=Hashable)

_ATTEMPTS = 12
"""Of a request that may get lost: with a tenth of the round trips lost, one in 10¹² stays unanswered."""
_FIRST_WINDOW, _LARGEST_WINDOW = 8, 20  # ArduPilot queues twenty requests
_FIRST_TIMEOUT_S, _SHORTEST_TIMEOUT_S, _LONGEST_TIMEOUT_S = 0.5, 0.1, 2.0


@dataclass(slots=True)
class _Asked:
    first_s: float
    last_s: float
    times: int = 1


class Exchange(Generic[K]):
    """The requests for `keys`, each repeated until it is answered or given up.

    Args:
        keys: what to ask for, in this order.
        ask: sends the request for one.
        attempts: how often to ask for one.

    Attributes:
        unanswered: what has no answer yet.
    """

    def __init__(self, keys: Iterable[K], ask: Callable[[K], None], *, attempts: int = _ATTEMPTS) -> None:
        self._waiting = deque(dict.fromkeys(keys))
        self.unanswered = set(self._waiting)
        self._ask = ask
        self._attempts = attempts
        self._under_way: dict[K, _Asked] = {}
        self._window = _FIRST_WINDOW
        self._shrunk_s = 0.0
        self._round_trip_s: float | None = None
        self._deviation_s = 0.0
        self._answered = asyncio.Event()

    def answered(self, key: K) -> None:
        """An answer came; one that nobody waits for is passed over."""
        if key not in self.unanswered:
            return
        self.unanswered.discard(key)
        asked = self._under_way.pop(key, None)
        self._window = min(self._window + 1, _LARGEST_WINDOW)
        if asked is not None and asked.times == 1:  # a repeat's answer may be the first one's (Karn)
            self._learn(clock.now() - asked.first_s)
        self._answered.set()

    async def run(self) -> None:
        """Ask until nothing is left to ask for; `unanswered` then has what was given up."""
        while True:
            self._answered.clear()
            self._repeat_what_is_late()
            while self._waiting and len(self._under_way) < self._window:
                key = self._waiting.popleft()
                if key in self.unanswered:
                    self._under_way[key] = _Asked(clock.now(), clock.now())
                    self._ask(key)
            if not self._under_way:
                return
            late_s = min(asked.last_s for asked in self._under_way.values()) + self._timeout_s
            try:
                async with asyncio.timeout_at(max(late_s, clock.now())):
                    await self._answered.wait()
            except TimeoutError:
                continue

    @property
    def _timeout_s(self) -> float:
        if self._round_trip_s is None:
            return _FIRST_TIMEOUT_S
        timeout_s = self._round_trip_s + 4.0 * self._deviation_s
        return min(max(timeout_s, _SHORTEST_TIMEOUT_S), _LONGEST_TIMEOUT_S)

    def _learn(self, round_trip_s: float) -> None:
        if self._round_trip_s is None:
            self._round_trip_s, self._deviation_s = round_trip_s, round_trip_s / 2.0
            return
        self._deviation_s += 0.25 * (abs(self._round_trip_s - round_trip_s) - self._deviation_s)
        self._round_trip_s += 0.125 * (round_trip_s - self._round_trip_s)

    def _repeat_what_is_late(self) -> None:
        now_s, timeout_s = clock.now(), self._timeout_s
        for key, asked in list(self._under_way.items()):
            if asked.last_s + timeout_s > now_s:
                continue
            if asked.times == self._attempts:
                del self._under_way[key]
                continue
            if now_s >= self._shrunk_s + timeout_s:
                self._window, self._shrunk_s = max(2, self._window // 2), now_s
            asked.times, asked.last_s = asked.times + 1, now_s
            self._ask(key)
