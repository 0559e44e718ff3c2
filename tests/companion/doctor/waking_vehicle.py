"""A scripted vehicle that boots: heartbeats at once, knows where it is later, sends what it is asked for."""

import asyncio
from collections.abc import Iterable
from typing import Any

from companion.link.dialect import Message, mavlink
from companion.link.framing import FrameSplitter, decode
from companion.link.memory import MemoryTransport
from companion.link.transport import Receiver

TICK_S = 0.02
READY_FLAGS, BOOTING_FLAGS = 0x33F, 0xA7  # with and without a horizontal position, as ArduPilot has them


class WakingVehicle:
    """ArduPilot-like; `ready_s` after its start its estimator and its checks before arming are content.

    Attributes:
        commands: MAV_CMD that it was sent.
        heard: ids of all messages that it was sent.
        parameters: what it answers for.
    """

    def __init__(self, ready_s: float, *, answers: bool = True) -> None:
        self.ready_s = ready_s
        self.answers = answers
        self.commands: list[int] = []
        self.heard: set[int] = set()
        self.parameters = {"GUID_TIMEOUT": 3.0, "ARMING_CHECK": 1.0}
        self._asked: set[int] = set()
        self._ticks = 0
        self._encoder = mavlink.MAVLink(None, srcSystem=1, srcComponent=1)
        self._splitter = FrameSplitter()

    async def open(self, receiver: Receiver) -> MemoryTransport:
        self._transport = MemoryTransport(receiver, self._hear)
        self._loop = asyncio.get_running_loop()
        self._tick()
        return self._transport

    @property
    def ready(self) -> bool:
        return self._ticks * TICK_S >= self.ready_s

    def _say(self, *messages: Message) -> None:
        for message in messages:
            self._transport.deliver(bytes(message.pack(self._encoder)))
            self._encoder.seq = (self._encoder.seq + 1) % 256

    def _tick(self) -> None:
        if self._ticks % 50 == 0:
            self._say(mavlink.MAVLink_heartbeat_message(2, mavlink.MAV_AUTOPILOT_ARDUPILOTMEGA, 1, 0, 3, 3))
            self._say(*(message for message in self._slow() if message.get_msgId() in self._asked))
        self._say(*(message for message in self._fast() if message.get_msgId() in self._asked))
        self._ticks += 1
        self._loop.call_later(TICK_S, self._tick)

    def _fast(self) -> Iterable[Message]:
        time_ms = round(self._ticks * TICK_S * 1e3)
        yield mavlink.MAVLink_attitude_message(time_ms, 0, 0, 0, 0, 0, 0)
        if self.ready:
            yield mavlink.MAVLink_local_position_ned_message(time_ms, 0, 0, 0, 0, 0, 0)

    def _slow(self) -> Iterable[Message]:
        health = mavlink.MAV_SYS_STATUS_PREARM_CHECK if self.ready else 0
        flags = READY_FLAGS if self.ready else BOOTING_FLAGS
        yield mavlink.MAVLink_sys_status_message(0, 0, health, 0, 12000, -1, 87, 0, 0, 0, 0, 0, 0)
        yield mavlink.MAVLink_ekf_status_report_message(flags, 0.1, 0.05, 0.02, 0.03, 0.0)
        yield mavlink.MAVLink_gps_raw_int_message(0, 3 if self.ready else 1, 0, 0, 0, 0, 0, 0, 0, 9)
        if self.ready:
            yield mavlink.MAVLink_home_position_message(0, 0, 0, 0, 0, 0, [1, 0, 0, 0], 0, 0, 0)

    def _hear(self, data: bytes) -> None:
        for frame in self._splitter.feed(data):
            message: Any = decode(frame)
            self.heard.add(frame.message_id)
            if self.answers:
                self._answer(message)

    def _answer(self, message: Any) -> None:
        match message:
            case mavlink.MAVLink_timesync_message(tc1=0):
                self._say(mavlink.MAVLink_timesync_message(tc1=self._ticks * 20_000_000 + 1, ts1=message.ts1))
            case mavlink.MAVLink_param_request_read_message() if message.param_id in self.parameters:
                value = self.parameters[message.param_id]
                self._say(mavlink.MAVLink_param_value_message(message.param_id.encode(), value, 9, 900, 3))
            case mavlink.MAVLink_command_long_message():
                self.commands.append(message.command)
                self._obey(message)

    def _obey(self, message: Any) -> None:
        match message.command:
            case mavlink.MAV_CMD_SET_MESSAGE_INTERVAL:
                self._asked.add(int(message.param1))
            case mavlink.MAV_CMD_REQUEST_MESSAGE:
                capabilities = mavlink.MAV_PROTOCOL_CAPABILITY_SET_POSITION_TARGET_LOCAL_NED
                self._say(
                    mavlink.MAVLink_autopilot_version_message(
                        capabilities, 0x04060000, 0, 0, 0, [0] * 8, [0] * 8, [0] * 8, 0, 0, 0xABC
                    )
                )
            case mavlink.MAV_CMD_RUN_PREARM_CHECKS if not self.ready:
                self._say(mavlink.MAVLink_statustext_message(2, b"PreArm: Need Position Estimate"))
                self._say(mavlink.MAVLink_statustext_message(6, b"chatter"))
        self._say(mavlink.MAVLink_command_ack_message(message.command, mavlink.MAV_RESULT_ACCEPTED))
