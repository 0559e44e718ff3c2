"""The mission protocol, for missions, fences and rally points: https://mavlink.io/en/services/mission.html.

What autopilots do beside it: PX4 answers MAV_MISSION_ERROR to what comes twice or while it is busy, and often
goes on; it ends a download in which a request comes out of order. ArduPilot answers
MAV_MISSION_INVALID_SEQUENCE to what comes twice, and goes on. So neither ends a transfer here before the
vehicle is silent as well; then it is begun again.
"""

import asyncio
from collections.abc import Awaitable, Callable, Iterator, Sequence
from contextlib import contextmanager, suppress
from typing import Any, NamedTuple, TypeAlias, TypeVar

from companion import clock
from companion.errors import LinkError, NoReplyError, RefusedError
from companion.link.connection import Connection
from companion.link.dialect import Message, mavlink

T = TypeVar("T")
M = TypeVar("M", bound=Message)

_Ack = mavlink.MAVLink_mission_ack_message
_Count = mavlink.MAVLink_mission_count_message
_ItemInt = mavlink.MAVLink_mission_item_int_message
_Request = mavlink.MAVLink_mission_request_message
_RequestInt = mavlink.MAVLink_mission_request_int_message

ShowTransfer: TypeAlias = Callable[[int, int], None]
"""Called with how many items have been transferred, and how many there are."""

_MESSAGE_TIMEOUT_S = 1.5
_ITEM_TIMEOUT_S = 0.25
_RETRIES = 5
_ATTEMPTS = 4
"""How often a transfer is begun, when it is disturbed each time."""
_PAUSE_S = 1.0
"""Before it is begun again: until nothing of the last one is still under way."""
_REASON_DELAY_S = 0.3
"""How long after a refusal its STATUSTEXT may still arrive."""
_PLANS = {
    mavlink.MAV_MISSION_TYPE_MISSION: "mission",
    mavlink.MAV_MISSION_TYPE_FENCE: "fence",
    mavlink.MAV_MISSION_TYPE_RALLY: "rally points",
}
_DISTURBED = frozenset(
    {
        mavlink.MAV_MISSION_ERROR,
        mavlink.MAV_MISSION_INVALID_SEQUENCE,
        mavlink.MAV_MISSION_OPERATION_CANCELLED,
        mavlink.MAV_MISSION_DENIED,
    }
)
"""Results that tell of a disturbance, or of a vehicle that is busy with another peer."""


class WireItem(NamedTuple):
    """What MISSION_ITEM_INT carries of an item, in its own units and order."""

    frame: int
    command: int
    autocontinue: int
    param1: float
    param2: float
    param3: float
    param4: float
    x: int
    y: int
    z: float


class DisturbedError(LinkError):
    """A transfer ended before its time; it may be begun again."""


async def upload_items(
    connection: Connection,
    mission_type: int,
    items: Sequence[WireItem],
    progress: ShowTransfer = lambda done, total: None,
) -> None:
    """Replace the vehicle's plan of `mission_type` (MAV_MISSION_TYPE) by `items`.

    Returns when the vehicle accepted them; or, for that answer may be lost and ArduPilot gives it once, when
    it asked for each and then for nothing more. Read them back to be sure.

    Raises:
        RefusedError: the vehicle refused; the message names the item, and has what the vehicle said.
        NoReplyError: it stopped answering.
        LinkError: it was busy or disturbed, again and again.
    """
    count = mavlink.MAVLink_mission_count_message(*connection.target, len(items), mission_type)
    await _repeatedly(connection, lambda: _offer(connection, count, items, progress))


async def clear_items(connection: Connection, mission_type: int) -> None:
    """Delete the vehicle's plan of `mission_type` (MAV_MISSION_TYPE); raises as `upload_items`."""
    clear = mavlink.MAVLink_mission_clear_all_message(*connection.target, mission_type)
    await _repeatedly(connection, lambda: _offer(connection, clear, (), lambda done, total: None))


async def download_items(
    connection: Connection, mission_type: int, progress: ShowTransfer = lambda done, total: None
) -> tuple[WireItem, ...]:
    """The vehicle's plan of `mission_type` (MAV_MISSION_TYPE); raises as `upload_items`."""
    return await _repeatedly(connection, lambda: _download(connection, mission_type, progress))


async def _repeatedly(connection: Connection, transfer: Callable[[], Awaitable[T]]) -> T:
    """What `transfer` gives, begun again when it is disturbed; one transfer at a time."""
    async with connection.exclusive("mission"):
        for _ in range(_ATTEMPTS - 1):
            with suppress(DisturbedError):
                return await transfer()
            await asyncio.sleep(_PAUSE_S)
        return await transfer()


async def _offer(
    connection: Connection, first: Any, items: Sequence[WireItem], progress: ShowTransfer
) -> None:
    """Send `first` (MISSION_COUNT or MISSION_CLEAR_ALL), and then each item that the vehicle asks for."""
    kind, last = first.mission_type, len(items) - 1
    talk = _Talk(connection, kind)
    message, asked, trouble = first, -1, None
    with talk.listening(_Ack, _Request, _RequestInt):
        connection.send(message)
        give_up_s = clock.now() + _RETRIES * _MESSAGE_TIMEOUT_S
        while clock.now() < give_up_s:
            match await talk.next(_MESSAGE_TIMEOUT_S):
                case None if trouble is not None and asked < last:
                    raise await talk.disturbed(trouble)
                case None:
                    connection.send(message)
                case _Ack(type=mavlink.MAV_MISSION_ACCEPTED):
                    if asked == last:  # else it belongs to an earlier transfer
                        return
                case _Ack(type=result) if result in _DISTURBED:
                    trouble = result
                case _Ack(type=result):
                    raise await talk.refused(result, asked)
                case _Request(seq=seq) | _RequestInt(seq=seq) if seq <= last:
                    if seq > asked:
                        asked, trouble = seq, None
                        give_up_s = clock.now() + _RETRIES * _MESSAGE_TIMEOUT_S
                        progress(seq + 1, len(items))
                    message = _item_message(connection, kind, seq, items[seq])
                    connection.send(message)
    if trouble is not None:
        raise await talk.disturbed(trouble)
    if asked < last or not items:
        where = f"{asked + 1} of {len(items)} items into the upload" if items else "when asked to clear"
        raise NoReplyError(f"{_PLANS[kind]}: the vehicle stopped answering, {where}")


async def _download(connection: Connection, kind: int, progress: ShowTransfer) -> tuple[WireItem, ...]:
    talk = _Talk(connection, kind)
    items: list[WireItem] = []
    with talk.listening(_Ack, _Count, _ItemInt):
        request: Message = mavlink.MAVLink_mission_request_list_message(*connection.target, kind)
        count = (await talk.ask(request, _Count, lambda answer: True, _MESSAGE_TIMEOUT_S)).count
        for seq in range(count):
            request = mavlink.MAVLink_mission_request_int_message(*connection.target, seq, kind)
            answer = await talk.ask(request, _ItemInt, _numbered(seq), _ITEM_TIMEOUT_S)
            items.append(_wire_item(answer))
            progress(seq + 1, count)
        accepted = mavlink.MAV_MISSION_ACCEPTED
        connection.send(_Ack(*connection.target, accepted, kind))
    return tuple(items)


class _Talk:
    """What the vehicle says to us about its plan of one kind, in the order in which it comes."""

    def __init__(self, connection: Connection, kind: int) -> None:
        self._connection = connection
        self._kind = kind
        self._began_s = clock.now()
        self._heard: asyncio.Queue[Any] = asyncio.Queue()

    @contextmanager
    def listening(self, *messages: type[Message]) -> Iterator[None]:
        """Hear these messages while the block runs."""
        ends = [self._connection.subscribe(message, self._hear) for message in messages]
        try:
            yield
        finally:
            for end in ends:
                end()

    async def next(self, timeout_s: float) -> Any:
        """The next message; None where there is none within `timeout_s` (s)."""
        with suppress(TimeoutError):
            async with asyncio.timeout(timeout_s):
                return await self._heard.get()
        return None

    async def ask(
        self, question: Message, kind: type[M], is_answer: Callable[[M], bool], timeout_s: float
    ) -> M:
        """The answer to `question`, which is asked again each `timeout_s` (s).

        Raises:
            DisturbedError, RefusedError, NoReplyError: there was none.
        """
        for _ in range(1 + _RETRIES):
            self._connection.send(question)
            ask_again_s = clock.now() + timeout_s
            while (left_s := ask_again_s - clock.now()) > 0.0:
                match await self.next(left_s):
                    case answer if isinstance(answer, kind) and is_answer(answer):
                        return answer
                    case _Ack(type=result) if result in _DISTURBED:
                        raise await self.disturbed(result)
                    case _Ack(type=result) if result != mavlink.MAV_MISSION_ACCEPTED:
                        raise await self.refused(result, getattr(question, "seq", -1))
        raise NoReplyError(f"{_PLANS[self._kind]}: the vehicle stopped answering {question.msgname}")

    async def disturbed(self, result: int) -> DisturbedError:
        """What to raise when the vehicle broke off."""
        what = f"{_PLANS[self._kind]}: the vehicle broke off the transfer ({_plain(result)})"
        return DisturbedError(f"{what}{await self._reason()}; is another ground station at it?")

    async def refused(self, result: int, seq: int) -> RefusedError:
        """What to raise when the vehicle refused, at item `seq` or, where that is -1, before any."""
        where = f" at item {seq}" if seq >= 0 else ""
        return RefusedError(f"{_PLANS[self._kind]}: refused{where} ({_plain(result)}){await self._reason()}")

    async def _reason(self) -> str:
        await asyncio.sleep(_REASON_DELAY_S)
        said = self._connection.status_texts.warnings_since(self._began_s)
        return "".join(f": {text}" for text in said[-1:])

    def _hear(self, message: Any) -> None:
        system_id, component_id = self._connection.ids
        to_us = message.target_system == system_id and message.target_component in (component_id, 0)
        if to_us and message.mission_type == self._kind:
            self._heard.put_nowait(message)


def _item_message(connection: Connection, kind: int, seq: int, item: WireItem) -> Message:
    return _ItemInt(
        *(*connection.target, seq, item.frame, item.command, seq == 0, item.autocontinue),
        *(item.param1, item.param2, item.param3, item.param4, item.x, item.y, item.z),
        mission_type=kind,
    )


def _numbered(seq: int) -> Callable[[mavlink.MAVLink_mission_item_int_message], bool]:
    return lambda message: message.seq == seq


def _wire_item(message: mavlink.MAVLink_mission_item_int_message) -> WireItem:
    return WireItem(*(getattr(message, field) for field in WireItem._fields))


def _plain(result: int) -> str:
    entry = mavlink.enums["MAV_MISSION_RESULT"].get(result)
    return entry.name.removeprefix("MAV_MISSION_") if entry else f"result {result}"
