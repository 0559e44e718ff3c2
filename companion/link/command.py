"""Commands to the vehicle, each answered in time or refused with the vehicle's own reason.

The command protocol: https://mavlink.io/en/services/command.html.
"""

import asyncio
from typing import TypeVar

from companion import clock
from companion.errors import NoReplyError, RefusedError
from companion.link.connection import Connection
from companion.link.dialect import Message, mavlink

M = TypeVar("M", bound=Message)

_PROGRESS_TIMEOUT_S = 10.0
"""How long a vehicle may be at a command after it said that it is."""
_REASON_DELAY_S = 0.3
"""How long after a refusal its STATUSTEXT may still arrive."""


async def command(
    connection: Connection, command_id: int, *params: float, attempt_timeout_s: float = 0.5, attempts: int = 4
) -> None:
    """Have the vehicle carry out a command, and wait until it says that it does.

    Args:
        connection: to the vehicle.
        command_id: MAV_CMD.
        params: parameters 1 to 7, in the command's own units; those left out are 0.
        attempt_timeout_s: how long to wait for an answer before asking again (s).
        attempts: how often to ask.

    Raises:
        NoReplyError: the vehicle did not answer.
        RefusedError: it refused; the message has its result, and what it said in words.
    """
    asked_s = clock.now()
    async with connection.exclusive(("command", command_id)):
        result = await _ask(connection, command_id, params, attempt_timeout_s, attempts)
    if result == mavlink.MAV_RESULT_ACCEPTED:
        return
    await asyncio.sleep(_REASON_DELAY_S)
    said = "; ".join(connection.status_texts.warnings_since(asked_s)) or "it gave no reason"
    what = _plain("MAV_CMD", command_id)
    raise RefusedError(f"the vehicle refused {what} ({_plain('MAV_RESULT', result)}): {said}")


async def set_message_interval(connection: Connection, message_id: int, rate_hz: float) -> None:
    """Have the vehicle send a message at `rate_hz` (Hz).

    Raises:
        NoReplyError: the vehicle did not answer.
        RefusedError: it does not send that message, or not at that rate.
    """
    await command(connection, mavlink.MAV_CMD_SET_MESSAGE_INTERVAL, message_id, 1e6 / rate_hz)


async def request_message(
    connection: Connection, kind: type[M], *, attempt_timeout_s: float = 0.5, attempts: int = 4
) -> M:
    """Have the vehicle send one message of `kind`, and wait for it.

    Raises:
        NoReplyError: it did not come.
    """
    request = (*connection.target, mavlink.MAV_CMD_REQUEST_MESSAGE)
    for attempt in range(attempts):
        connection.send(mavlink.MAVLink_command_long_message(*request, attempt, kind.id, 0, 0, 0, 0, 0, 0))
        try:
            return await connection.receive(kind, timeout_s=attempt_timeout_s)
        except NoReplyError:
            continue
    raise NoReplyError(f"the vehicle did not send {kind.msgname}, asked {attempts} times")


async def _ask(
    connection: Connection,
    command_id: int,
    params: tuple[float, ...],
    attempt_timeout_s: float,
    attempts: int,
) -> int:
    """The MAV_RESULT with which the command ended."""
    results: asyncio.Queue[int] = asyncio.Queue()

    def take(answer: mavlink.MAVLink_command_ack_message) -> None:
        if answer.command == command_id and connection.is_for_us(answer):
            results.put_nowait(answer.result)

    unsubscribe = connection.subscribe(mavlink.MAVLink_command_ack_message, take)
    filled = (*params, *[0.0] * 7)[:7]
    try:
        for attempt in range(attempts):
            connection.send(
                mavlink.MAVLink_command_long_message(*connection.target, command_id, attempt, *filled)
            )
            try:
                async with asyncio.timeout(attempt_timeout_s):
                    result = await results.get()
                async with asyncio.timeout(_PROGRESS_TIMEOUT_S):
                    while result == mavlink.MAV_RESULT_IN_PROGRESS:
                        result = await results.get()
            except TimeoutError:
                continue
            return result
    finally:
        unsubscribe()
    raise NoReplyError(f"the vehicle did not answer {_plain('MAV_CMD', command_id)}, asked {attempts} times")


def _plain(enum: str, value: int) -> str:
    """The name of a value of a MAVLink enumeration, without the enumeration's own name."""
    entry = mavlink.enums[enum].get(value)
    return entry.name.removeprefix(f"{enum}_") if entry else f"{enum} {value}"
