"""The connection to one vehicle: its messages in, ours out, and whether it is still there.

Several vehicles, ground stations and companions may speak on one link. State and replies are taken from
the autopilot of the system that was connected to, and from nobody else.
"""

import asyncio
from collections import defaultdict
from collections.abc import AsyncIterator, Callable
from contextlib import aclosing, asynccontextmanager
from typing import Any, TypeVar

from companion.errors import LinkError, NoReplyError
from companion.link.courtesy import QUESTIONS, answers
from companion.link.dialect import Message, mavlink
from companion.link.framing import Frame, FrameCounts, FrameSplitter, decode
from companion.link.lasting import LastingTransport, OpenTransport, open_lasting
from companion.link.presence import Presence
from companion.link.signing import Signer
from companion.link.status_text import StatusTexts
from companion.link.tasks import Spawn, background_tasks
from companion.link.transport import Transport

M = TypeVar("M", bound=Message)

_HEARTBEAT_INTERVAL_S = 1.0
_COMPONENT_ID = mavlink.MAV_COMP_ID_ONBOARD_COMPUTER
_AUTOPILOT = mavlink.MAV_COMP_ID_AUTOPILOT1
_SYSTEM_ID_BEFORE_ANY_IS_KNOWN = 1


@asynccontextmanager
async def connect_over(
    opener: OpenTransport,
    *,
    system_id: int | None = None,
    signer: Signer | None = None,
    timeout_s: float = 10.0,
) -> AsyncIterator["Connection"]:
    """Connect to the vehicle on the transport that `opener` opens, until the block ends.

    Args:
        opener: called again when that breaks.
        system_id: of the vehicle; without it, the first vehicle that is heard.
        signer: signs what is sent and judges what is received; without it, anything is believed.
        timeout_s: how long to wait for the vehicle's heartbeat (s).

    Raises:
        LinkError: the transport cannot be opened, or no vehicle is there.
    """
    connection = Connection(system_id, signer)
    async with aclosing(await open_lasting(opener, connection)) as transport, background_tasks() as spawn:
        spawn(transport.keep_open())
        connection.start(transport, spawn)
        await connection.find_vehicle(timeout_s)
        yield connection


class Connection:
    """A vehicle that was found, and the way to it; made by `connect` and `connect_over`.

    Attributes:
        spawn: starts a task that ends with the connection, and ends the connection when it fails.
        system_id: of the vehicle, and therefore ours too; 0 until it is found.
        presence: whether the vehicle is still heard.
        status_texts: what the vehicle said in words.
        strange_frames: how many valid frames came from other systems and components.
        signer: signs what is sent and judges what is received, None where nothing is signed.
        vehicle_signs: whether the vehicle signs its frames, so that it may take none but signed ones.
    """

    spawn: Spawn
    _transport: LastingTransport

    def __init__(self, system_id: int | None, signer: Signer | None = None) -> None:
        self.system_id = system_id or 0
        self.signer = signer
        self.vehicle_signs = False
        self.presence = Presence()
        self.status_texts = StatusTexts()
        self.strange_frames = 0
        self._heartbeat: mavlink.MAVLink_heartbeat_message | None = None
        self._strange_systems: set[int] = set()
        self._found = asyncio.Event()
        self._failure: asyncio.Future[None] = asyncio.get_running_loop().create_future()
        self._splitter = FrameSplitter()
        self._encoder = mavlink.MAVLink(
            None, srcSystem=system_id or _SYSTEM_ID_BEFORE_ANY_IS_KNOWN, srcComponent=_COMPONENT_ID
        )
        self._handlers: dict[int, tuple[Callable[[Any], None], ...]] = {}
        self._listeners: tuple[Callable[[bytes], None], ...] = ()
        self._locks: defaultdict[object, asyncio.Lock] = defaultdict(asyncio.Lock)
        self.subscribe(mavlink.MAVLink_statustext_message, self.status_texts.add)

    def start(self, transport: LastingTransport, spawn: Spawn) -> None:
        """Begin to heartbeat on `transport`; every later failure ends the tasks of `spawn`."""
        self._transport, self.spawn = transport, spawn
        spawn(self._fail_with_the_link())
        spawn(self._send_heartbeats())
        spawn(self.presence.watch())

    async def find_vehicle(self, timeout_s: float) -> None:
        """Wait for the first heartbeat of the vehicle.

        Raises:
            LinkError: there was none within `timeout_s` (s).
        """
        try:
            async with asyncio.timeout(timeout_s):
                await self._found.wait()
        except TimeoutError:
            raise LinkError(f"no vehicle heard within {timeout_s:g} s: {self._why_none()}") from None

    @property
    def heartbeat(self) -> mavlink.MAVLink_heartbeat_message:
        """The vehicle's newest heartbeat."""
        assert self._heartbeat is not None, "connect() gives a connection only when the vehicle was heard"
        return self._heartbeat

    @property
    def transport(self) -> Transport:
        """What carries the bytes now."""
        return self._transport.current

    @property
    def lost(self) -> bool:
        """Whether the vehicle fell silent."""
        return self.presence.lost

    @property
    def frame_counts(self) -> FrameCounts:
        """What the link carried so far, whoever sent it."""
        return self._splitter.counts

    @property
    def ids(self) -> tuple[int, int]:
        """Our own system and component id."""
        return self._encoder.srcSystem, self._encoder.srcComponent

    @property
    def target(self) -> tuple[int, int]:
        """System and component id of the vehicle's autopilot."""
        return self.system_id, _AUTOPILOT

    def is_for_us(self, message: Any) -> bool:
        """Whether a message that names a target means us, or everyone: 0, as in all that is left out."""
        system_id, component_id = self.ids
        return message.target_system in (0, system_id) and message.target_component in (0, component_id)

    def exclusive(self, key: object) -> asyncio.Lock:
        """The lock of requests whose answers cannot be told apart: one such request at a time."""
        return self._locks[key]

    def send(self, message: Message) -> None:
        """Send `message` now, or drop it where the transport cannot take it; never waits."""
        data = message.pack(self._encoder)
        self._encoder.seq = (self._encoder.seq + 1) % 256
        if self.signer:
            data = self.signer.sign(data)
        self._transport.send(data)
        self._let_overhear(data)

    def relay(self, frame: Frame) -> None:
        """Pass on, as it is, a frame of somebody who reaches the vehicle through us."""
        self._transport.send(frame.data)
        if frame.message_id in QUESTIONS and self._believes(frame):
            self._answer(frame)

    def overhear(self, listener: Callable[[bytes], None]) -> Callable[[], None]:
        """Call `listener` with each frame on the link, whoever sent it; returns what ends that."""
        self._listeners += (listener,)

        def leave() -> None:
            self._listeners = tuple(other for other in self._listeners if other is not listener)

        return leave

    def subscribe(self, kind: type[M], handler: Callable[[M], None]) -> Callable[[], None]:
        """Call `handler` with each message of `kind` from the vehicle, as it arrives; returns what ends that.

        Messages that nobody subscribed to are not decoded.
        """
        message_id = kind.id
        self._handlers[message_id] = (*self._handlers.get(message_id, ()), handler)

        def unsubscribe() -> None:
            others = tuple(other for other in self._handlers[message_id] if other is not handler)
            self._handlers[message_id] = others

        return unsubscribe

    async def receive(
        self, kind: type[M], matches: Callable[[M], bool] = lambda message: True, *, timeout_s: float
    ) -> M:
        """The next message of `kind` that `matches`.

        Raises:
            NoReplyError: there was none within `timeout_s` (s).
        """
        arrived: asyncio.Future[M] = asyncio.get_running_loop().create_future()

        def take(message: M) -> None:
            if not arrived.done() and matches(message):
                arrived.set_result(message)

        unsubscribe = self.subscribe(kind, take)
        try:
            async with asyncio.timeout(timeout_s):
                return await arrived
        except TimeoutError:
            raise NoReplyError(f"no {kind.msgname} from the vehicle within {timeout_s:g} s") from None
        finally:
            unsubscribe()

    def bytes_received(self, data: bytes) -> None:
        """Hand on what the transport received; an error in a handler ends the connection."""
        try:
            for frame in self._splitter.feed(data):
                self._let_overhear(frame.data)
                if self._believes(frame):
                    self._dispatch(frame)
        except Exception as error:
            self._fail(error)

    def transport_lost(self, error: Exception) -> None:
        """The transport failed in a way that opening it again does not mend: so does the connection."""
        self._fail(error)

    def _let_overhear(self, data: bytes) -> None:
        for listener in self._listeners:
            listener(data)

    def _answer(self, frame: Frame) -> None:
        for answer in answers(decode(frame), self.ids):
            self.send(answer)

    def _believes(self, frame: Frame) -> bool:
        rejection = self.signer.rejection(frame) if self.signer else None
        if rejection and rejection.is_authentic and self._heartbeat is None:
            # A vehicle whose clock is behind ours has to hear of our time before it can be believed.
            self._transport.answer_sender()
        return rejection is None

    def _dispatch(self, frame: Frame) -> None:
        if frame.message_id == mavlink.MAVLINK_MSG_ID_HEARTBEAT:
            self._notice_heartbeat(frame)
        elif self._heartbeat is None:
            return
        if frame.message_id in QUESTIONS:
            self._answer(frame)
        if frame.system_id != self.system_id or frame.component_id != _AUTOPILOT:
            self.strange_frames += 1
            return
        self.presence.heard()
        handlers = self._handlers.get(frame.message_id)
        if handlers:
            message = decode(frame)
            for handler in handlers:
                handler(message)

    def _notice_heartbeat(self, frame: Frame) -> None:
        message = decode(frame)
        assert isinstance(message, mavlink.MAVLink_heartbeat_message)
        if frame.component_id != _AUTOPILOT or message.autopilot == mavlink.MAV_AUTOPILOT_INVALID:
            return  # a ground station, a camera, another companion
        if self.system_id not in (0, frame.system_id):
            self._strange_systems.add(frame.system_id)
            return
        self.system_id = self._encoder.srcSystem = frame.system_id
        self._heartbeat, self.vehicle_signs = message, frame.signed
        self._transport.answer_sender()
        self._found.set()

    def _why_none(self) -> str:
        if self._strange_systems:
            others = ", ".join(map(str, sorted(self._strange_systems)))
            return f"system {self.system_id} is silent, but these speak: {others}. Connect to one of them"
        if self.signer and self.signer.rejected:
            refused = ", ".join(f"{count} {reason}" for reason, count in self.signer.rejected.items())
            return f"frames arrive, but are not believed ({refused}). Give the vehicle and us the same key"
        if self.frame_counts.frames:
            return "there is MAVLink traffic, but no autopilot's heartbeat in it. Check what is connected"
        if self.frame_counts.stray_bytes:
            return "bytes arrive, but no MAVLink. Check the baud rate, and what is connected"
        return "nothing arrives. Check that the vehicle is powered and that it sends to this very address"

    def _fail(self, error: Exception) -> None:
        if not self._failure.done():
            self._failure.set_exception(error)

    async def _fail_with_the_link(self) -> None:
        await self._failure

    async def _send_heartbeats(self) -> None:
        heartbeat = mavlink.MAVLink_heartbeat_message(
            type=mavlink.MAV_TYPE_ONBOARD_CONTROLLER,
            autopilot=mavlink.MAV_AUTOPILOT_INVALID,
            base_mode=0,
            custom_mode=0,
            system_status=mavlink.MAV_STATE_ACTIVE,
            mavlink_version=3,
        )
        while True:
            self.send(heartbeat)
            self.status_texts.finish_old()
            await asyncio.sleep(_HEARTBEAT_INTERVAL_S)
