"""A byte stream in, MAVLink 1 and 2 frames out: https://mavlink.io/en/guide/serialization.html.

A frame is believed only when its checksum is right. Anything else is passed over one byte at a time, so
that stray bytes, even such as look like the start of a frame, never cost a valid frame behind them.
"""

import re
import struct
from collections.abc import Callable
from dataclasses import dataclass
from enum import Enum, auto
from functools import cache
from typing import NamedTuple, cast

from fastcrc.crc16 import mcrf4xx

from companion.link.dialect import Message, mavlink

_V1, _V2 = 0xFE, 0xFD
_START = re.compile(rb"[\xfd\xfe]")
# Version 1: length, sequence, system, component, message id.
_HEADER_V1 = struct.Struct("<xBBBBB")
# Version 2: length, incompatible flags, sequence, system, component, message id (low 16 bits, high 8).
_HEADER_V2 = struct.Struct("<xBBxBBBHB")
_CHECKSUM = struct.Struct("<H")
_SIGNED = mavlink.MAVLINK_IFLAG_SIGNED
_SIGNATURE_LENGTH = mavlink.MAVLINK_SIGNATURE_BLOCK_LEN

_MESSAGES: dict[int, type[Message]] = mavlink.mavlink_map
_SEEDS_AND_SIZES = {
    message_id: (bytes([kind.crc_extra]), kind.unpacker.size) for message_id, kind in _MESSAGES.items()
}


class Frame(NamedTuple):
    """One frame whose checksum was right; its payload may lack trailing zeros, `data` is all of it."""

    message_id: int
    system_id: int
    component_id: int
    sequence: int
    payload: bytes
    data: bytes

    @property
    def signed(self) -> bool:
        """Whether it carries a signature, right or wrong."""
        return self.data[0] == _V2 and bool(self.data[2] & _SIGNED)


class NoFrame(Enum):
    """Why bytes that begin like a frame are none."""

    UNFINISHED = auto()
    BAD_CHECKSUM = auto()
    UNKNOWN_MESSAGE = auto()
    IMPOSSIBLE = auto()


@dataclass(slots=True)
class FrameCounts:
    """What a stream carried so far.

    Attributes:
        frames: valid frames.
        bad_checksums: what looked like a frame of a known message, but had another checksum.
        unknown_messages: what looked like a frame of a message that the dialect does not know.
        stray_bytes: bytes that belonged to no valid frame.
    """

    frames: int = 0
    bad_checksums: int = 0
    unknown_messages: int = 0
    stray_bytes: int = 0


class FrameSplitter:
    """Cuts a byte stream into frames; keeps at most one unfinished frame between calls."""

    def __init__(self) -> None:
        self.counts = FrameCounts()
        self._unfinished = b""

    def feed(self, data: bytes) -> list[Frame]:
        """The frames that `data` completes, in order of arrival. Never raises, whatever the bytes."""
        stream = self._unfinished + data if self._unfinished else data
        counts = self.counts
        frames: list[Frame] = []
        at, end = 0, len(stream)
        while at < end:
            start = at if stream[at] == _V2 else next_start(stream, at)
            counts.stray_bytes += start - at
            at = start
            if at == end:
                break
            found = frame_at(stream, at)
            if found is NoFrame.UNFINISHED:
                break
            if isinstance(found, NoFrame):
                counts.bad_checksums += found is NoFrame.BAD_CHECKSUM
                counts.unknown_messages += found is NoFrame.UNKNOWN_MESSAGE
                counts.stray_bytes += 1
                at += 1
            else:
                frame, at = found
                frames.append(frame)
        self._unfinished = stream[at:]
        counts.frames += len(frames)
        return frames


def frame_at(stream: bytes, at: int) -> tuple[Frame, int] | NoFrame:
    """The frame that begins at `at`, where its first byte is right, and where it ends; or why it is none."""
    version_2 = stream[at] == _V2
    header_length = 10 if version_2 else 6
    if len(stream) - at < header_length:
        return NoFrame.UNFINISHED
    if version_2:
        payload_length, flags, sequence, system_id, component_id, low, high = _HEADER_V2.unpack_from(
            stream, at
        )
        message_id = low | high << 16
    else:
        payload_length, sequence, system_id, component_id, message_id = _HEADER_V1.unpack_from(stream, at)
        flags = 0
    if flags & ~_SIGNED:
        return NoFrame.IMPOSSIBLE
    if message_id not in _SEEDS_AND_SIZES:
        return NoFrame.UNKNOWN_MESSAGE
    seed, size = _SEEDS_AND_SIZES[message_id]
    if payload_length > size and not version_2:  # only version 2 lets a message grow
        return NoFrame.IMPOSSIBLE
    checksum_at = at + header_length + payload_length
    frame_end = checksum_at + 2 + (_SIGNATURE_LENGTH if flags & _SIGNED else 0)
    if frame_end > len(stream):
        return NoFrame.UNFINISHED
    checksum = mcrf4xx(seed, mcrf4xx(stream[at + 1 : checksum_at]))
    if checksum != _CHECKSUM.unpack_from(stream, checksum_at)[0]:
        return NoFrame.BAD_CHECKSUM
    payload = stream[at + header_length : checksum_at]
    data = stream[at:frame_end]
    return Frame(message_id, system_id, component_id, sequence, payload, data), frame_end


def next_start(stream: bytes, at: int) -> int:
    """Where the next byte is with which a frame can begin; the stream's length when there is none."""
    found = _START.search(stream, at)
    return found.start() if found else len(stream)


def marked_signed(data: bytes) -> bytes:
    """The unsigned MAVLink 2 frame `data` as it is before a signature: flag and checksum changed."""
    marked = bytes([_V2, data[1], data[2] | _SIGNED]) + data[3:-2]
    seed, _ = _SEEDS_AND_SIZES[int.from_bytes(data[7:10], "little")]
    return marked + _CHECKSUM.pack(mcrf4xx(seed, mcrf4xx(marked[1:])))


def decode(frame: Frame) -> Message:
    """The message in `frame`; its source is as the frame says.

    Bytes that a shorter payload lacks are zeros, bytes that this dialect does not know are passed over.
    """
    kind = _MESSAGES[frame.message_id]
    payload = frame.payload.ljust(kind.unpacker.size, b"\0")
    fields = _field_picker(frame.message_id)(kind.unpacker.unpack_from(payload))
    message = cast(Callable[..., Message], kind)(*fields)
    header = message.get_header()
    header.seq, header.srcSystem, header.srcComponent = frame.sequence, frame.system_id, frame.component_id
    return message


_Values = tuple[object, ...]


@cache
def _field_picker(message_id: int) -> Callable[[_Values], _Values]:
    """How unpacked numbers, in the order of the wire, become the arguments of a message's class."""
    kind = _MESSAGES[message_id]
    starts = [sum(kind.lengths[:place]) for place in range(len(kind.lengths))]
    fields = [(starts[place], kind.lengths[place]) for place in kind.orders]
    if fields == [(place, 1) for place in range(len(fields))]:
        return lambda values: values
    if all(length == 1 for _, length in fields):
        return lambda values: tuple([values[start] for start, _ in fields])
    return lambda values: tuple(
        values[start] if length == 1 else list(values[start : start + length]) for start, length in fields
    )
