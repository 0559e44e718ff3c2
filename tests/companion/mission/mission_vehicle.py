"""A scripted vehicle that keeps plans as strictly as PX4 or ArduPilot, behind a link that may be rough."""

import asyncio
import functools
from collections.abc import Callable, Coroutine
from dataclasses import dataclass
from typing import Any

import numpy as np

from companion import clock
from companion.link.dialect import Message, mavlink
from companion.link.framing import FrameSplitter, decode
from companion.link.mission import WireItem
from companion.link.transport import Receiver

PX4, ARDUPILOT = mavlink.MAV_AUTOPILOT_PX4, mavlink.MAV_AUTOPILOT_ARDUPILOTMEGA
MISSION, FENCE, RALLY = range(3)
OURS = (1, mavlink.MAV_COMP_ID_ONBOARD_COMPUTER)
Ack = mavlink.MAVLink_mission_ack_message
ERROR, ACCEPTED = mavlink.MAV_MISSION_ERROR, mavlink.MAV_MISSION_ACCEPTED


def in_virtual_time(test: Callable[..., Coroutine[Any, Any, None]]) -> Callable[..., None]:
    """Run an asynchronous test in a loop that never waits."""

    @functools.wraps(test)
    def run(*args: Any, **kwargs: Any) -> None:
        clock.run(test(*args, **kwargs), virtual=True)

    return run


@dataclass(frozen=True)
class Trouble:
    """What a link does to frames, from one seed."""

    lost: float = 0.0
    duplicated: float = 0.0
    reordered: float = 0.0
    jitter_s: float = 0.0
    seed: int = 0


ROUGH = Trouble(lost=0.05, duplicated=0.02, reordered=0.02, jitter_s=0.05)


class MissionVehicle:
    """A vehicle at the other end of a link.

    Attributes:
        plans: what it keeps, by MAV_MISSION_TYPE.
        heard: what it was sent.
        mute_after: it stops answering when it has heard so many messages of the mission protocol.
        refuses: the result with which it refuses the item of that number.
        busy: so many MISSION_COUNT or MISSION_REQUEST_LIST are answered with MAV_MISSION_ERROR.
        float_requests: asks by MISSION_REQUEST.
        swallows_last_ack: never sends MAV_MISSION_ACCEPTED.
        spoils: what becomes of an item that it stores.
    """

    def __init__(self, autopilot: int = PX4, trouble: Trouble = Trouble()) -> None:
        self.plans: dict[int, list[WireItem]] = {MISSION: [], FENCE: [], RALLY: []}
        self.heard: list[Any] = []
        self.mute_after = 10**9
        self.refuses: tuple[int, int] | None = None
        self.busy = 0
        self.float_requests = autopilot == ARDUPILOT
        self.swallows_last_ack = False
        self.home: tuple[float, float, float] | None = (47.397742, 8.545594, 488.0)
        self.spoils: Callable[[WireItem], WireItem] = lambda item: item
        self.dropped = 0
        self._autopilot = autopilot
        self._trouble = trouble
        self._random = np.random.default_rng(trouble.seed)
        self._splitter = FrameSplitter()
        self._encoder = mavlink.MAVLink(None, srcSystem=1, srcComponent=1)
        self._kind = MISSION
        self._count = self._next = 0
        self._receiving = False
        self._incoming: list[WireItem] = []
        self._sending: int | None = None
        self._timer: asyncio.TimerHandle | None = None

    async def open(self, receiver: Receiver) -> "MissionVehicle":
        self._receiver = receiver
        self._loop = asyncio.get_running_loop()
        beat = mavlink.MAVLink_heartbeat_message(2, self._autopilot, 0, 0, mavlink.MAV_STATE_STANDBY, 3)
        for second in range(2000):
            self._loop.call_later(0.1 + second, self.say, beat)
        return self

    def answer_sender(self) -> None: ...

    async def aclose(self) -> None: ...

    def send(self, data: bytes) -> None:
        self._carry(bytes(data), self._hear)

    def say(self, message: Message) -> None:
        self._carry(bytes(message.pack(self._encoder)), self._receiver.bytes_received)

    def _carry(self, data: bytes, deliver: Callable[[bytes], None]) -> None:
        trouble, random = self._trouble, self._random
        for _ in range(1 + int(random.random() < trouble.duplicated)):
            if random.random() >= trouble.lost:
                late_s = 0.03 if random.random() < trouble.reordered else 0.0
                self._loop.call_later(late_s + trouble.jitter_s * random.random(), deliver, data)

    def _hear(self, data: bytes) -> None:
        for frame in self._splitter.feed(data):
            message = decode(frame)
            if isinstance(message, mavlink.MAVLink_command_long_message):
                self._tell_home()
            elif message.get_msgId() != mavlink.MAVLINK_MSG_ID_HEARTBEAT:
                self.heard.append(message)
                if len(self.heard) <= self.mute_after:
                    self._answer(message)

    def _tell_home(self) -> None:
        if self.home is not None:
            latitude, longitude, altitude = self.home
            place = (round(latitude * 1e7), round(longitude * 1e7), round(altitude * 1e3))
            self.say(mavlink.MAVLink_home_position_message(*place, 0, 0, 0, [1, 0, 0, 0], 0, 0, 0))

    def _answer(self, message: Any) -> None:
        match message:
            case mavlink.MAVLink_mission_count_message():
                self._begin(message)
            case mavlink.MAVLink_mission_item_int_message():
                self._take(message)
            case mavlink.MAVLink_mission_clear_all_message():
                self.plans[message.mission_type] = []
                self._acknowledge(ACCEPTED, message.mission_type)
            case mavlink.MAVLink_mission_request_list_message():
                self._list(message.mission_type)
            case mavlink.MAVLink_mission_request_int_message():
                self._give(message.seq, message.mission_type)
            case Ack():
                self._receiving, self._sending = False, None

    def _begin(self, message: Any) -> None:
        if self.busy or (self._receiving and self._next > 0 and self._autopilot == PX4):
            self.busy = max(0, self.busy - 1)
            return self._acknowledge(ERROR, message.mission_type)
        self._kind, self._count, self._next = message.mission_type, message.count, 0
        self._incoming, self._receiving = [], True
        if self._autopilot == ARDUPILOT:  # not atomic
            self.plans[self._kind] = self.plans[self._kind][: message.count]
        return self._request() if message.count else self._finish()

    def _request(self) -> None:
        numbers = (*OURS, self._next, self._kind)
        if self.float_requests:
            self.say(mavlink.MAVLink_mission_request_message(*numbers))
        else:
            self.say(mavlink.MAVLink_mission_request_int_message(*numbers))
        if self._timer is not None:
            self._timer.cancel()
        self._timer = self._loop.call_later(0.25 if self._autopilot == PX4 else 1.0, self._again, 20)

    def _again(self, left: int) -> None:
        if self._receiving and left and len(self.heard) < self.mute_after:
            self._request()

    def _take(self, message: Any) -> None:
        expected = self._receiving and message.seq == self._next and message.mission_type == self._kind
        if not expected:
            return self._unexpected(message.seq)
        if self.refuses is not None and self.refuses[0] == message.seq:
            self._receiving = False
            return self._acknowledge(self.refuses[1], self._kind)
        item = self.spoils(WireItem(*(getattr(message, field) for field in WireItem._fields)))
        self._incoming.append(item)
        if self._autopilot == ARDUPILOT:
            self.plans[self._kind][message.seq : message.seq + 1] = [item]
        self._next += 1
        return self._request() if self._next < self._count else self._finish()

    def _unexpected(self, seq: int) -> None:
        if self._autopilot == ARDUPILOT:
            if self._receiving:
                self._acknowledge(mavlink.MAV_MISSION_INVALID_SEQUENCE, self._kind)
        elif not self._receiving:
            self._acknowledge(ACCEPTED if seq + 1 == self._next else ERROR, self._kind)

    def _finish(self) -> None:
        self._receiving = False
        self.plans[self._kind] = list(self._incoming)
        if not self.swallows_last_ack:
            self._acknowledge(ACCEPTED, self._kind)

    def _list(self, kind: int) -> None:
        if self.busy:
            self.busy -= 1
            return self._acknowledge(ERROR, kind)
        self._sending = 0
        return self.say(mavlink.MAVLink_mission_count_message(*OURS, len(self.plans[kind]), kind))

    def _give(self, seq: int, kind: int) -> None:
        if self._autopilot == PX4:  # a request out of order ends the download
            if self._sending is None:
                return None
            if seq not in (self._sending, self._sending - 1):
                self._sending = None
                return self._acknowledge(ERROR, kind)
            self._sending = seq + 1
        frame, command, *rest = self.plans[kind][seq]
        item: Any = mavlink.MAVLink_mission_item_int_message
        return self.say(item(*OURS, seq, frame, command, seq == 0, *rest, kind))

    def _acknowledge(self, result: int, kind: int) -> None:
        self.say(Ack(*OURS, result, kind))
