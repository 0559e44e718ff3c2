"""How often the vehicle sends what: asked for, and again when it has forgotten or sends too seldom."""

import asyncio
import contextlib
import math
from collections import Counter
from collections.abc import Container, Iterable, Mapping

from companion import clock
from companion.errors import NoReplyError, RefusedError
from companion.link.command import set_message_interval
from companion.link.connection import Connection
from companion.link.dialect import Message, mavlink
from companion.link.presence import LinkChange

_LOOK_EVERY_S = 3.0
_INTERVALS = 3.0
"""A message that has not come for three of its intervals, and for the time of a look, is missed."""
_SELDOM = 1.0 / 8.0
"""So is one that comes at less than this share of its rate: a ground station on the same link has asked for
its own (MAVProxy has ArduPilot send all at 4 Hz, every 15 s). A slow link or vehicle gives more than this."""
_LONGEST_PATIENCE_S = 30.0
"""Between two questions for what never comes, such as the home position of a vehicle without GPS."""


class MessageRates:
    """The rates (Hz), by message id, at which a vehicle is to send.

    One that refuses a rate sends at its own, and is not asked again before its next start. Messages of
    `at_times` are those that it sends in some of its modes only, and that are not missed.
    """

    def __init__(
        self, connection: Connection, rates_hz: Mapping[int, float], at_times: Container[int] = ()
    ) -> None:
        self._connection = connection
        self._rates_hz = dict(rates_hz)
        self._at_times = at_times
        self._to_ask = set(self._rates_hz)
        self._refused: set[int] = set()
        self._heard_s = dict.fromkeys(self._rates_hz, -math.inf)
        self._came: Counter[int] = Counter()
        self._ask_at_s = dict.fromkeys(self._rates_hz, -math.inf)
        self._patience_s = dict.fromkeys(self._rates_hz, _LOOK_EVERY_S)
        self._forgotten = asyncio.Event()
        for message_id in self._rates_hz:
            connection.subscribe(mavlink.mavlink_map[message_id], self._on_message)
        connection.presence.subscribe(self._on_link_change)

    async def ask(self) -> None:
        """Ask for all.

        Raises:
            NoReplyError: the vehicle answers no commands.
        """
        await self._ask(self._rates_hz)

    def ask_again(self) -> None:
        """The vehicle has begun anew, and knows of no wishes."""
        self._to_ask = set(self._rates_hz)
        self._refused.clear()
        self._forgotten.set()

    async def keep(self) -> None:
        """Ask again for what is missed, until cancelled; less and less often where that is of no use."""
        while True:
            began_s = clock.now()
            self._came.clear()
            with contextlib.suppress(TimeoutError):
                async with asyncio.timeout(_LOOK_EVERY_S):
                    await self._forgotten.wait()
            self._forgotten.clear()
            if not self._connection.lost:
                with contextlib.suppress(NoReplyError):
                    await self._ask(self._due(clock.now() - began_s))

    async def _ask(self, message_ids: Iterable[int]) -> None:
        for message_id in message_ids:
            try:
                await set_message_interval(self._connection, message_id, self._rates_hz[message_id])
            except RefusedError:
                self._refused.add(message_id)
            self._to_ask.discard(message_id)

    def _due(self, elapsed_s: float) -> list[int]:
        """What to ask for now, `elapsed_s` (s) after the last look."""
        now_s = clock.now()
        due = []
        for message_id in self._rates_hz:
            if message_id in self._to_ask:
                due.append(message_id)
            elif message_id in self._refused or not self._is_missed(message_id, elapsed_s):
                self._patience_s[message_id] = _LOOK_EVERY_S
            elif now_s >= self._ask_at_s[message_id]:
                due.append(message_id)
                self._ask_at_s[message_id] = now_s + self._patience_s[message_id]
                self._patience_s[message_id] = min(2.0 * self._patience_s[message_id], _LONGEST_PATIENCE_S)
        return due

    def _is_missed(self, message_id: int, elapsed_s: float) -> bool:
        if message_id in self._at_times:
            return False
        rate_hz = self._rates_hz[message_id]
        silence_s = clock.now() - self._heard_s[message_id]
        return silence_s > max(_LOOK_EVERY_S, _INTERVALS / rate_hz) or self._came[message_id] < int(
            _SELDOM * rate_hz * elapsed_s
        )

    def _on_message(self, message: Message) -> None:
        self._heard_s[message.get_msgId()] = clock.now()
        self._came[message.get_msgId()] += 1

    def _on_link_change(self, change: LinkChange) -> None:
        if not change.lost:
            self.ask_again()
