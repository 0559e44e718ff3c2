"""A scripted vehicle that keeps parameters, behind a link that loses, repeats, reorders and delays frames."""

import asyncio
import math
import struct
from dataclasses import dataclass
from typing import Any

import numpy as np
from fake_vehicle import encoder, heartbeat

from companion.link.dialect import Message, mavlink
from companion.link.framing import FrameSplitter, decode
from companion.link.parameter_encoding import Encoding, Number, ParameterType, encode_value
from companion.link.transport import Receiver

PX4, ARDUPILOT = mavlink.MAV_AUTOPILOT_PX4, mavlink.MAV_AUTOPILOT_ARDUPILOTMEGA
_CAPABILITIES = {
    Encoding.BYTEWISE: mavlink.MAV_PROTOCOL_CAPABILITY_PARAM_ENCODE_BYTEWISE,
    Encoding.CAST: mavlink.MAV_PROTOCOL_CAPABILITY_PARAM_ENCODE_C_CAST,
}


@dataclass(frozen=True)
class Trouble:
    """What a link does to frames, from one seed."""

    lost: float = 0.0
    duplicated: float = 0.0
    reordered: float = 0.0
    jitter_s: float = 0.0
    seed: int = 0


ROUGH = Trouble(lost=0.05, duplicated=0.02, reordered=0.02, jitter_s=0.05)


class ParameterVehicle:
    """Answers the parameter protocol as PX4 or ArduPilot does, at 500 parameters a second.

    Attributes:
        values: its parameters; `read_only` ones it keeps as they are.
        requests: what it was asked.
        count_changes_at: tells one parameter more from its n-th PARAM_VALUE on.
    """

    def __init__(
        self,
        values: dict[str, tuple[Number, ParameterType]],
        encoding: Encoding,
        trouble: Trouble = Trouble(),
    ) -> None:
        self.values = values
        self.encoding = encoding
        self.read_only: set[str] = set()
        self.says_errors = False
        self.tells_capabilities = True
        self.requests: list[Any] = []
        self.newcomer: tuple[int, str] | None = None
        self.told = 0
        self.dropped = 0
        self._trouble = trouble
        self._random = np.random.default_rng(trouble.seed)
        self._splitter = FrameSplitter()
        self._encoder = encoder()

    async def open(self, receiver: Receiver) -> "ParameterVehicle":
        self._receiver = receiver
        self._loop = asyncio.get_running_loop()
        autopilot = PX4 if self.encoding is Encoding.BYTEWISE else ARDUPILOT
        for beat in range(1000):
            self._loop.call_later(0.1 + beat, self.say, heartbeat(autopilot))
        return self

    def answer_sender(self) -> None: ...

    async def aclose(self) -> None: ...

    def send(self, data: bytes) -> None:
        self._carry(data, self._hear)

    def say(self, message: Message) -> None:
        self._carry(bytes(message.pack(self._encoder)), self._receiver.bytes_received)

    def _carry(self, data: bytes, deliver: Any) -> None:
        trouble, random = self._trouble, self._random
        for _ in range(1 + int(random.random() < trouble.duplicated)):
            if random.random() < trouble.lost:
                continue
            delay_s = trouble.jitter_s * random.random() + (
                0.03 if random.random() < trouble.reordered else 0.0
            )
            self._loop.call_later(delay_s, deliver, data)

    def _hear(self, data: bytes) -> None:
        for frame in self._splitter.feed(data):
            message = decode(frame)
            if isinstance(message, mavlink.MAVLink_heartbeat_message):
                continue
            self.requests.append(message)
            self._answer(message)

    def _answer(self, message: Any) -> None:
        names = list(self.values)
        match message:
            case mavlink.MAVLink_param_request_list_message():
                if self.encoding is Encoding.BYTEWISE:
                    self.say(mavlink.MAVLink_param_value_message(b"_HASH_CHECK", 1e-9, 5, len(names), 65535))
                for place, name in enumerate(names):
                    self._loop.call_later(0.002 * place, self._tell, name)
            case mavlink.MAVLink_param_request_read_message(param_index=-1):
                self._tell_or_refuse(message.param_id)
            case mavlink.MAVLink_param_request_read_message():
                if message.param_index < len(names):
                    self._tell(names[message.param_index])
            case mavlink.MAVLink_param_set_message():
                self._set(message)
            case mavlink.MAVLink_command_long_message() if self.tells_capabilities:
                self.say(
                    mavlink.MAVLink_autopilot_version_message(
                        _CAPABILITIES[self.encoding], 1 << 24, 0, 0, 0, [0] * 8, [0] * 8, [0] * 8, 0, 0, 0
                    )
                )

    def _set(self, message: Any) -> None:
        name = message.param_id
        if name in self.values and name not in self.read_only:
            kind = self.values[name][1]
            self.values[name] = (self._decoded(message.param_value, kind), kind)
        self._tell_or_refuse(name, refused=name in self.read_only)

    def _decoded(self, field: float, kind: ParameterType) -> Number:
        if kind is ParameterType.REAL32:
            return field
        if self.encoding is Encoding.CAST:
            return int(field)
        (value,) = struct.unpack("<i", struct.pack("<f", field))
        return int(value)

    def _tell_or_refuse(self, name: str, *, refused: bool = False) -> None:
        if self.says_errors and (refused or name not in self.values):
            error = mavlink.MAV_PARAM_ERROR_READ_ONLY if refused else mavlink.MAV_PARAM_ERROR_DOES_NOT_EXIST
            self.say(mavlink.MAVLink_param_error_message(255, 190, name.encode(), -1, error))
        elif name in self.values:
            self._tell(name)

    def _tell(self, name: str) -> None:
        self.told += 1
        if self.newcomer is not None and self.told == self.newcomer[0]:
            self.values = {self.newcomer[1]: (1, ParameterType.INT32)} | self.values
        value, kind = self.values[name]
        index = list(self.values).index(name)
        self.say(
            mavlink.MAVLink_param_value_message(
                name.encode(), encode_value(value, kind, self.encoding), kind, len(self.values), index
            )
        )


def many(count: int) -> dict[str, tuple[Number, ParameterType]]:
    """Integers and floats in turn, the first with a name of sixteen characters."""
    values: dict[str, tuple[Number, ParameterType]] = {"SIXTEEN_LETTERS_": (-7, ParameterType.INT32)}
    for number in range(count - 1):
        if number % 2:
            values[f"INT_{number}"] = (number - 300, ParameterType.INT32)
        else:
            values[f"REAL_{number}"] = (float(np.float32(math.sqrt(number))), ParameterType.REAL32)
    return values
