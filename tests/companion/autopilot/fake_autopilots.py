"""Scripted autopilots at the far end of an in-memory link: they do what they are told."""

import asyncio
from collections.abc import AsyncIterator, Callable, Iterable
from contextlib import asynccontextmanager
from typing import Any

from companion.link.connection import Connection, connect_over
from companion.link.dialect import Message, mavlink
from companion.link.framing import FrameSplitter, decode
from companion.link.memory import MemoryTransport
from companion.link.telemetry import Telemetry
from companion.link.transport import Receiver

OFFBOARD, LOITER, POSCTL = 6 << 16, 4 << 16 | 3 << 24, 3 << 16
STABILIZE, GUIDED, LAND, BRAKE = 0, 4, 9, 17
Command = mavlink.MAVLink_command_long_message


class FakePx4:
    """Speaks at 10 Hz; `answers` overrules what it makes of a MAV_CMD: the messages that it sends back."""

    mode = POSCTL

    def __init__(self, autopilot: int = mavlink.MAV_AUTOPILOT_PX4) -> None:
        self.autopilot = autopilot
        self.type = mavlink.MAV_TYPE_QUADROTOR
        self.armed = False
        self.knows_where_it_is = True
        self.altitude_m = 0.0
        self.commands: list[Any] = []
        self.setpoints: list[Any] = []
        self.answers: dict[int, Callable[[], Iterable[Message]]] = {}
        self.parameters: dict[str, float] = {}
        self._encoder = mavlink.MAVLink(None, srcSystem=1, srcComponent=1)
        self._splitter = FrameSplitter()

    @asynccontextmanager
    async def flown(self) -> AsyncIterator[tuple[Connection, Telemetry]]:
        """A connection to it, and its telemetry."""
        async with connect_over(self._open) as connection:
            yield connection, Telemetry(connection)

    def say(self, *messages: Message) -> None:
        for message in messages:
            self._transport.deliver(message.pack(self._encoder))

    async def _open(self, receiver: Receiver) -> MemoryTransport:
        self._transport = MemoryTransport(receiver, self._hear)
        self._loop = asyncio.get_running_loop()
        self._time_ms = 0
        self._live()
        return self._transport

    def place(self) -> Message:
        above_home_mm = round(self.altitude_m * 1e3)
        return mavlink.MAVLink_global_position_int_message(
            self._time_ms, 0, 0, 488_000 + above_home_mm, above_home_mm, 0, 0, 0, 0
        )

    def _live(self) -> None:
        flags = mavlink.MAV_MODE_FLAG_SAFETY_ARMED if self.armed else 0
        up_m = self.altitude_m
        landed = mavlink.MAV_LANDED_STATE_IN_AIR if up_m else mavlink.MAV_LANDED_STATE_ON_GROUND
        self.say(
            mavlink.MAVLink_heartbeat_message(self.type, self.autopilot, flags, self.mode, 4, 3),
            mavlink.MAVLink_attitude_message(self._time_ms, 0, 0, 0, 0, 0, 0),
            mavlink.MAVLink_extended_sys_state_message(0, landed),
        )
        if self.knows_where_it_is:
            self.say(mavlink.MAVLink_local_position_ned_message(self._time_ms, 0, 0, -up_m, 0, 0, 0))
        self._tell_place()
        self._time_ms += 100
        self._loop.call_later(0.1, self._live)

    def _tell_place(self) -> None:
        self.say(self.place())

    def _hear(self, data: bytes) -> None:
        for frame in self._splitter.feed(data):
            message = decode(frame)
            if isinstance(message, Command):
                self.commands.append(message)
                answer = self.answers.get(message.command)
                self.say(*(answer() if answer else self._obey(message)))
            elif isinstance(message, mavlink.MAVLink_set_position_target_local_ned_message):
                self.setpoints.append(message)
            elif isinstance(message, mavlink.MAVLink_param_request_read_message):
                name = message.param_id
                if name in self.parameters:
                    value = self.parameters[name]
                    self.say(mavlink.MAVLink_param_value_message(name.encode(), value, 9, 1, 65535))

    def _obey(self, message: Any) -> Iterable[Message]:
        match message.command:
            case mavlink.MAV_CMD_COMPONENT_ARM_DISARM:
                self.armed = message.param1 == 1.0
            case mavlink.MAV_CMD_NAV_TAKEOFF:
                self.altitude_m = message.param7 - 488.0
            case mavlink.MAV_CMD_NAV_LAND:
                self.altitude_m, self.armed = 0.0, False
            case mavlink.MAV_CMD_DO_SET_MODE:
                self.mode = int(message.param2) << 16 | int(message.param3) << 24
        return [accepted(message.command)]


class FakeArduPilot(FakePx4):
    """Likewise, as ArduPilot understands it: it tells its place on the map only when asked."""

    mode = STABILIZE

    def __init__(self) -> None:
        super().__init__(mavlink.MAV_AUTOPILOT_ARDUPILOTMEGA)

    def _tell_place(self) -> None: ...

    def _obey(self, message: Any) -> Iterable[Message]:
        match message.command:
            case mavlink.MAV_CMD_REQUEST_MESSAGE:
                return [accepted(message.command), self.place()]
            case mavlink.MAV_CMD_NAV_TAKEOFF:
                if not self.armed or self.mode != GUIDED:
                    return [mavlink.MAVLink_command_ack_message(message.command, mavlink.MAV_RESULT_FAILED)]
                self.altitude_m = message.param7
            case mavlink.MAV_CMD_NAV_LAND:
                self.altitude_m, self.armed, self.mode = 0.0, False, LAND
            case mavlink.MAV_CMD_DO_SET_MODE:
                self.mode = int(message.param2)
            case _:
                return super()._obey(message)
        return [accepted(message.command)]


def accepted(command: int) -> Message:
    return mavlink.MAVLink_command_ack_message(command, mavlink.MAV_RESULT_ACCEPTED)


def refused(command: int, reason: str) -> list[Message]:
    return [
        mavlink.MAVLink_command_ack_message(command, mavlink.MAV_RESULT_TEMPORARILY_REJECTED),
        mavlink.MAVLink_statustext_message(mavlink.MAV_SEVERITY_CRITICAL, reason.encode()),
    ]
