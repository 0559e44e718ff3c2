"""How often the vehicle sends what: asked for, and asked for again when it has forgotten or stays silent."""

import asyncio
import contextlib
import math
from collections.abc import Iterable, Mapping

from companion import clock
from companion.errors import NoReplyError, RefusedError
from companion.link.command import set_message_interval
from companion.link.connection import Connection
from companion.link.dialect import Message, mavlink
from companion.link.presence import LinkChange

_PATIENCE_S = 3.0
"""A message that has not come for this long, or for three of its intervals, is missed."""
_LONGEST_PATIENCE_S = 30.0
"""Between two questions for what never comes, such as the home position of a vehicle without GPS."""


class MessageRates:
    """The rates (Hz), by message id, at which a vehicle is to send.

    One that refuses a rate sends at its own, and is not asked again before its next start.
    """

    def __init__(self, connection: Connection, rates_hz: Mapping[int, float]) -> None:
        self._connection = connection
        self._rates_hz = dict(rates_hz)
        self._to_ask = set(self._rates_hz)
        self._refused: set[int] = set()
        self._heard_s = dict.fromkeys(self._rates_hz, -math.inf)
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
        """Ask again for what is missing, until cancelled; less and less often where that is of no use."""
        patience_s = _PATIENCE_S
        while True:
            with contextlib.suppress(TimeoutError):
                async with asyncio.timeout(patience_s):
                    await self._forgotten.wait()
                    patience_s = _PATIENCE_S
            self._forgotten.clear()
            missing = [] if self._connection.lost else self._missing()
            patience_s = min(2.0 * patience_s, _LONGEST_PATIENCE_S) if missing else _PATIENCE_S
            with contextlib.suppress(NoReplyError):
                await self._ask(missing)

    async def _ask(self, message_ids: Iterable[int]) -> None:
        for message_id in message_ids:
            try:
                await set_message_interval(self._connection, message_id, self._rates_hz[message_id])
            except RefusedError:
                self._refused.add(message_id)
            self._to_ask.discard(message_id)

    def _missing(self) -> list[int]:
        now_s = clock.now()
        return [
            message_id
            for message_id, rate_hz in self._rates_hz.items()
            if message_id in self._to_ask
            or (
                message_id not in self._refused
                and now_s - self._heard_s[message_id] > max(_PATIENCE_S, 3.0 / rate_hz)
            )
        ]

    def _on_message(self, message: Message) -> None:
        self._heard_s[message.get_msgId()] = clock.now()

    def _on_link_change(self, change: LinkChange) -> None:
        if not change.lost:
            self.ask_again()
