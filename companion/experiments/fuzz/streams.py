"""MAVLink streams of valid frames between mutated ones and noise, and what a reader must find there.

A valid frame may be full of nonsense as long as its checksum is right: any number, any command, any sender.
"""

import re
import struct
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from typing import TypeVar

import numpy as np
from fastcrc.crc16 import mcrf4xx

from companion.experiments.fuzz.mutation import BYTES, mutated
from companion.link.dialect import Message, mavlink

T = TypeVar("T")

SILENCE = bytes(280)
"""Longer than any frame: behind it, nothing is waited for."""

_KINDS: Sequence[type[Message]] = tuple(mavlink.mavlink_map.values())
_COMMANDS = tuple(mavlink.enums["MAV_CMD"])
_FIELD = re.compile(r"(\d*)([a-zA-Z])")
_STRAY = (b"\xfd\xff", b"\xfe\xff", b"\xfd", b"\xfe\x09", b"\xfd\x10\x00", b"\xfd" * 12, b"\xfe" * 9)
_FLOATS = (0.0, 1.0, -1.0, np.nan, np.inf, -np.inf, 3e38, -3e38, 1e-40, 2.0**31, 180.0, 1e7)
_SENDERS = ((1, 1), (1, 1), (1, 1), (1, 191), (255, 190), (1, 0), (0, 0), (2, 1), (255, 255))
_TARGETS = (0, 1, 1, 191, 255)
_V1, _V2 = b"\xfe", b"\xfd"
_SIGNED = mavlink.MAVLINK_IFLAG_SIGNED
_SIGNATURE_LENGTH = mavlink.MAVLINK_SIGNATURE_BLOCK_LEN


@dataclass(frozen=True)
class Stream:
    """What is sent.

    Attributes:
        data: all bytes, silence at the end.
        valid: the valid frames in it: where each begins, and its bytes.
    """

    data: bytes
    valid: Sequence[tuple[int, bytes]]


@dataclass(frozen=True)
class Reading:
    """How many of the valid frames of a stream were read.

    Attributes:
        read: so many.
        swallowed: lie in a longer frame before them whose checksum happens to be right, too.
        lost: all others.
    """

    read: int
    swallowed: int
    lost: int


def frame(
    message_id: int, payload: bytes, sender: tuple[int, int], sequence: int, *, signed: bool = False
) -> bytes:
    """A MAVLink 2 frame with the right checksum and, if signed, a wrong signature."""
    flags = _SIGNED if signed else 0
    head = struct.pack(
        "<BBBBBBHB", len(payload), flags, 0, sequence, *sender, message_id & 0xFFFF, message_id >> 16
    )
    return _checked(_V2, head + payload, message_id) + bytes(_SIGNATURE_LENGTH if signed else 0)


def frame_v1(message_id: int, payload: bytes, sender: tuple[int, int], sequence: int) -> bytes:
    """A MAVLink 1 frame with the right checksum; `message_id` is below 256."""
    head = struct.pack("<BBBBB", len(payload), sequence, *sender, message_id)
    return _checked(_V1, head + payload, message_id)


def message_id(frame: bytes) -> int:
    """Of a valid frame."""
    return frame[5] if frame[:1] == _V1 else int.from_bytes(frame[7:10], "little")


def random_stream(pieces: int, kinds: Sequence[type[Message]], rng: np.random.Generator) -> Stream:
    """A stream of so many pieces, half of its messages of these kinds, the others of any."""
    valid: list[tuple[int, bytes]] = []
    data = bytearray()
    for place in range(pieces):
        kind = _one_of(kinds if rng.random() < 0.5 else _KINDS, rng)
        whole = _random_frame(kind, place % 256, rng)
        fate = rng.integers(4)
        if fate == 0:
            data += _one_of(_STRAY, rng)
        if fate == 1:
            data += rng.bytes(int(rng.integers(1, 64)))
        if fate == 2:
            data += mutated(whole, BYTES, rng)
        else:
            valid.append((len(data), whole))
            data += whole
    return Stream(bytes(data) + SILENCE, valid)


def reading(stream: Stream, frames: Iterable[bytes]) -> Reading:
    """How a reader did that found these frames, in the order of the stream."""
    spans = list(_spans(stream.data, frames))
    starts = {start for start, _ in spans}
    missing = [start for start, _ in stream.valid if start not in starts]
    swallowed = sum(any(start < place < end for start, end in spans) for place in missing)
    return Reading(len(stream.valid) - len(missing), swallowed, len(missing) - swallowed)


def _spans(data: bytes, frames: Iterable[bytes]) -> Iterator[tuple[int, int]]:
    end = 0
    for found in frames:
        start = data.index(found, end)
        end = start + len(found)
        yield start, end


def _random_frame(kind: type[Message], sequence: int, rng: np.random.Generator) -> bytes:
    payload = _random_payload(kind, rng)
    sender = _one_of(_SENDERS, rng)
    if kind.id < 256 and rng.random() < 0.2:
        return frame_v1(kind.id, payload, sender, sequence)
    if rng.random() < 0.2:
        payload = payload[: rng.integers(1, len(payload) + 1)]
    return frame(kind.id, payload, sender, sequence, signed=bool(rng.random() < 0.05))


def _random_payload(kind: type[Message], rng: np.random.Generator) -> bytes:
    size = kind.unpacker.size
    if rng.random() < 0.2:
        return rng.bytes(size)
    values: list[object] = []
    for (count, letter), name in zip(
        _FIELD.findall(kind.unpacker.format), kind.ordered_fieldnames, strict=True
    ):
        if letter == "s":
            values.append(rng.bytes(int(count)))
        else:
            values += [_random_value(name, letter, rng) for _ in range(int(count or 1))]
    return kind.unpacker.pack(*values)


def _random_value(name: str, letter: str, rng: np.random.Generator) -> object:
    if letter == "c":
        return rng.bytes(1)
    if letter in "fd":
        return float(rng.normal() * 10.0) if rng.random() < 0.7 else _one_of(_FLOATS, rng)
    if name == "command":
        return _one_of(_COMMANDS, rng) % 2**16
    if name.startswith("target_"):
        return _one_of(_TARGETS, rng)
    numbers = np.iinfo(np.dtype(letter))
    anything = int(rng.integers(numbers.min, numbers.max, endpoint=True, dtype=numbers.dtype))
    return _one_of((0, 1, 2, int(rng.integers(8)), int(numbers.min), int(numbers.max), anything), rng)


def _one_of(choices: Sequence[T], rng: np.random.Generator) -> T:
    return choices[int(rng.integers(len(choices)))]


def _checked(marker: bytes, content: bytes, message_id: int) -> bytes:
    crc_extra = bytes([mavlink.mavlink_map[message_id].crc_extra])
    return marker + content + struct.pack("<H", mcrf4xx(content + crc_extra))
