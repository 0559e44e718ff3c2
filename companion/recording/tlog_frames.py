"""Telemetry logs as QGroundControl, MAVProxy and Mission Planner write them: MAVLink frames with stamps.

The stamp is eight bytes before the frame: microseconds of Unix time, big-endian, when the frame was received
or sent: https://docs.qgroundcontrol.com/master/en/qgc-dev-guide/file_formats/mavlink.html
"""

import struct
from collections.abc import Iterator, Sequence
from typing import NamedTuple, TypeAlias

import numpy as np
from jaxtyping import Float

from companion.arrays import Array, Times
from companion.link.dialect import Message
from companion.link.framing import Frame, NoFrame, frame_at, next_start

_STAMP = struct.Struct(">Q")


class Stamped(NamedTuple):
    """A frame and when it was received or sent (Unix time, s)."""

    time_s: float
    frame: Frame


Frames: TypeAlias = Sequence[Stamped]


def stamped(unix_s: float, frame: bytes) -> bytes:
    """A frame as a telemetry log has it, received or sent at `unix_s` (Unix time, s)."""
    return _STAMP.pack(round(unix_s * 1e6)) + frame


def stamped_frames(log: bytes) -> Iterator[Stamped]:
    """The valid frames in `log`, in its order; whatever is none is passed over, a cut last frame too."""
    at = 0
    while (start := next_start(log, at + _STAMP.size)) < len(log):
        found = frame_at(log, start)
        if isinstance(found, NoFrame):
            at = start + 1 - _STAMP.size
        else:
            (microseconds,) = _STAMP.unpack_from(log, start - _STAMP.size)
            frame, at = found
            yield Stamped(microseconds * 1e-6, frame)


def times(frames: Frames) -> Times:
    """The stamps of `frames` (Unix time, s)."""
    return np.array([stamped.time_s for stamped in frames])


def columns(kind: type[Message], frames: Frames, *names: str) -> Float[Array, "n k"]:
    """The fields called `names` of messages that are all of one `kind`, a row each; arrays have no columns.

    Many times faster than a message object for each frame.
    """
    size = kind.unpacker.size
    payloads = b"".join(frame.payload[:size].ljust(size, b"\0") for _, frame in frames)
    places = [sum(kind.lengths[: kind.ordered_fieldnames.index(name)]) for name in names]
    rows = [[fields[place] for place in places] for fields in kind.unpacker.iter_unpack(payloads)]
    return np.array(rows, dtype=np.float64).reshape(-1, len(names))
