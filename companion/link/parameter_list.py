"""All parameters of a vehicle: asked for at once, the gaps then filled one by one, by index."""

import asyncio
from collections.abc import Callable, Mapping
from typing import TypeAlias

from companion.errors import NoReplyError
from companion.link.connection import Connection
from companion.link.dialect import mavlink
from companion.link.parameter import parameter_in
from companion.link.parameter_encoding import Encoding, Parameter
from companion.link.parameter_exchange import Exchange

Progress: TypeAlias = Callable[[int, int], None]
"""Told how many parameters are there, and how many there are in all."""

_NO_INDEX = 65535
"""Of a parameter outside the list: PX4's _HASH_CHECK, and what ArduPilot tells of a change."""
_QUIET_S = 1.0
"""The vehicle is done, or its frames got lost, when it sent no parameter for this long."""
_CALLS = 4
_RESTARTS = 5


async def list_parameters(
    connection: Connection, encoding: Encoding, *, progress: Progress = lambda done, total: None
) -> Mapping[str, Parameter]:
    """All parameters of the connection's vehicle, by name, in the vehicle's own order.

    Raises:
        NoReplyError: the vehicle sends none, or not all of them.
    """
    arrivals = _Arrivals(encoding, progress)
    unsubscribe = connection.subscribe(mavlink.MAVLink_param_value_message, arrivals.take)
    try:
        await _call_for_all(connection, arrivals)
        for _ in range(_RESTARTS):
            missing = await _fill_gaps(connection, arrivals)
            if not missing and arrivals.complete:
                return arrivals.by_name()
    finally:
        unsubscribe()
    raise NoReplyError(
        f"the vehicle sent {len(arrivals.by_index)} of {arrivals.count} parameters: check the link"
    )


class _Arrivals:
    """What came of the list so far, by index."""

    def __init__(self, encoding: Encoding, progress: Progress) -> None:
        self.by_index: dict[int, Parameter] = {}
        self.count: int | None = None
        self.on_index: Callable[[int], None] = lambda index: None
        self._encoding = encoding
        self._progress = progress
        self._came = asyncio.Event()

    def take(self, message: mavlink.MAVLink_param_value_message) -> None:
        index = message.param_index
        if index == _NO_INDEX or index >= message.param_count:
            return
        if self.count not in (None, message.param_count):
            self.by_index.clear()  # an option was switched on or off, and every index may have moved
        self.count = message.param_count
        self.by_index[index] = parameter_in(message, self._encoding)
        self._progress(len(self.by_index), self.count)
        self.on_index(index)
        self._came.set()

    @property
    def complete(self) -> bool:
        return self.count is not None and len(self.by_index) == self.count

    def missing(self) -> list[int]:
        return [index for index in range(self.count or 0) if index not in self.by_index]

    def by_name(self) -> Mapping[str, Parameter]:
        return {parameter.name: parameter for _, parameter in sorted(self.by_index.items())}

    async def more(self) -> bool:
        """Whether another one came before it had been quiet for too long."""
        self._came.clear()
        try:
            async with asyncio.timeout(_QUIET_S):
                await self._came.wait()
        except TimeoutError:
            return False
        return True


async def _call_for_all(connection: Connection, arrivals: _Arrivals) -> None:
    """Ask for the list, and take what comes until it stops."""
    for _ in range(_CALLS):
        connection.send(mavlink.MAVLink_param_request_list_message(*connection.target))
        while not arrivals.complete and await arrivals.more():
            pass
        if arrivals.count is not None:
            return
    raise NoReplyError(f"the vehicle sent no parameters, asked {_CALLS} times")


async def _fill_gaps(connection: Connection, arrivals: _Arrivals) -> set[int]:
    """Ask for each index that is missing; those for which nothing came."""

    def ask(index: int) -> None:
        connection.send(
            mavlink.MAVLink_param_request_read_message(*connection.target, param_id=b"", param_index=index)
        )

    exchange = Exchange(arrivals.missing(), ask)
    arrivals.on_index = exchange.answered
    await exchange.run()
    return exchange.unanswered
