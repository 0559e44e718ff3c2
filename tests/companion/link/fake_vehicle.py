"""A scripted vehicle at the far end of an in-memory link, and tests in virtual time."""

import asyncio
import functools
from collections.abc import Callable, Coroutine, Iterable
from typing import Any

from companion import clock
from companion.link.dialect import Message, mavlink
from companion.link.framing import Frame, FrameSplitter, decode
from companion.link.memory import MemoryTransport
from companion.link.transport import Receiver

PX4, ONBOARD = mavlink.MAV_AUTOPILOT_PX4, mavlink.MAV_COMP_ID_ONBOARD_COMPUTER
Script = Callable[[Any], Iterable[Message]]


def in_virtual_time(test: Callable[..., Coroutine[Any, Any, None]]) -> Callable[..., None]:
    """Run an asynchronous test in a loop that never waits; no task may outlive it."""

    @functools.wraps(test)
    def run(*args: Any, **kwargs: Any) -> None:
        async def whole() -> None:
            await test(*args, **kwargs)
            assert asyncio.all_tasks() == {asyncio.current_task()}

        clock.run(whole(), virtual=True)

    return run


def encoder(system_id: int = 1, component_id: int = 1) -> mavlink.MAVLink:
    return mavlink.MAVLink(None, srcSystem=system_id, srcComponent=component_id)


def heartbeat(autopilot: int = PX4, kind: int = mavlink.MAV_TYPE_QUADROTOR) -> Message:
    return mavlink.MAVLink_heartbeat_message(kind, autopilot, 0, 0, mavlink.MAV_STATE_STANDBY, 3)


class FakeVehicle:
    """Says what a test has it say, and answers by its `script`: a function for each kind of message."""

    def __init__(self, *, system_id: int = 1, heartbeats: int = 1000, autopilot: int = PX4) -> None:
        self.script: dict[type[Message], Script] = {}
        self.heard: list[Any] = []
        self.frames: list[Frame] = []
        self.system_id = system_id
        self._heartbeats = heartbeats
        self._autopilot = autopilot
        self._splitter = FrameSplitter()

    async def open(self, receiver: Receiver) -> MemoryTransport:
        self.transport = MemoryTransport(receiver, self._hear)
        loop = asyncio.get_running_loop()
        for beat in range(self._heartbeats):
            loop.call_later(0.1 + beat, self.say, heartbeat(self._autopilot))
        return self.transport

    def say(self, message: Message, *, system_id: int | None = None, component_id: int = 1) -> None:
        self.deliver(message.pack(encoder(system_id or self.system_id, component_id)))

    def deliver(self, data: bytes) -> None:
        self.transport.deliver(data)

    def heard_of(self, kind: type[Message]) -> list[Any]:
        return [message for message in self.heard if isinstance(message, kind)]

    def _hear(self, data: bytes) -> None:
        for frame in self._splitter.feed(data):
            message = decode(frame)
            self.frames.append(frame)
            self.heard.append(message)
            for answer in self.script.get(type(message), lambda message: ())(message):
                self.say(answer)
