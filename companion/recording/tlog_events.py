"""What happened in a flight, in words: from the messages in which an autopilot says so."""

from collections.abc import Iterator
from typing import Any, TypeAlias

from pymavlink import mavutil

from companion.link.dialect import mavlink
from companion.link.framing import decode
from companion.recording.tlog_frames import Frames

Event: TypeAlias = tuple[float, str]
"""When (s), and what."""


def texts(frames: Frames) -> Iterator[Event]:
    """STATUSTEXT: each text, its chunks joined, when it began (Unix time)."""
    begun_s, text, unfinished = 0.0, "", 0
    for time_s, message in _messages(frames):
        if text and (message.id != unfinished or message.chunk_seq == 0):
            yield begun_s, f"vehicle: {text}"
            text = ""
        begun_s = begun_s if text else time_s
        text, unfinished = text + message.text, message.id
        if not unfinished:
            yield begun_s, f"vehicle: {text}"
            text = ""
    if text:
        yield begun_s, f"vehicle: {text}"


def modes(frames: Frames) -> Iterator[Event]:
    """HEARTBEAT: when the vehicle was armed, disarmed, or changed its mode (Unix time)."""
    known = None
    for time_s, message in _messages(frames):
        armed = "armed" if message.base_mode & mavlink.MAV_MODE_FLAG_SAFETY_ARMED else "disarmed"
        mode = mavutil.mode_string_v10(message)
        if (armed, mode) != known:
            yield time_s, f"vehicle: {armed}, mode {mode}"
        known = (armed, mode)


def answers(frames: Frames) -> Iterator[Event]:
    """COMMAND_ACK: how the vehicle answered which command (Unix time)."""
    for time_s, message in _messages(frames):
        command, result = _name("MAV_CMD", message.command), _name("MAV_RESULT", message.result)
        yield time_s, f"vehicle: {command}: {result}"


def _messages(frames: Frames) -> Iterator[tuple[float, Any]]:
    return ((time_s, decode(frame)) for time_s, frame in frames)


def _name(enum: str, value: int) -> str:
    """What `value` is called, without the enum's own prefix; the number where it has no name."""
    entry = mavlink.enums[enum].get(value)
    return str(value) if entry is None else str(entry.name).removeprefix(f"{enum}_")
