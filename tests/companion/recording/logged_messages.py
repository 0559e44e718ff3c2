"""Telemetry logs made for the tests: messages and when they were received."""

from collections.abc import Iterable, Iterator
from typing import TypeAlias

from companion.link.dialect import Message, mavlink

UNIX_S = 1.8e9
"""When the vehicle was started."""

Logged: TypeAlias = tuple[float, bytes]


def frame(
    message: Message, system: int = 1, component: int = 1, *, signed: bool = False, v1: bool = False
) -> bytes:
    peer = mavlink.MAVLink(None, srcSystem=system, srcComponent=component)
    if signed:
        peer.signing.secret_key = bytes(32)
        peer.signing.sign_outgoing = True
    return bytes(message.pack(peer, force_mavlink1=v1))


def stamped(time_s: float, content: bytes) -> bytes:
    return round((UNIX_S + time_s) * 1e6).to_bytes(8, "big") + content


def log(lines: Iterable[Logged]) -> bytes:
    return b"".join(stamped(time_s, content) for time_s, content in sorted(lines, key=lambda line: line[0]))


def position(time_s: float) -> Message:
    """At 1 m/s to the north."""
    return mavlink.MAVLink_local_position_ned_message(round(time_s * 1e3), time_s, 0.0, -8.0, 1.0, 0.0, 0.0)


def attitude(time_s: float) -> Message:
    return mavlink.MAVLink_attitude_message(round(time_s * 1e3), 0.125, -0.25, 0.5, 0.01, 0.02, 0.03)


def telemetry(
    start_s: float = 0.0, seconds: float = 2.0, *, booted_s: float = 0.0, system: int = 1, component: int = 1
) -> Iterator[Logged]:
    """Position and attitude at 50 Hz, both 4 ms late; the vehicle's clock began at `booted_s`."""
    for step in range(round(seconds * 50)):
        time_s = start_s + step / 50.0
        for message in (attitude(time_s - booted_s), position(time_s - booted_s)):
            yield time_s + 0.004, frame(message, system, component)


def setpoint(
    mask: int = 0,
    *,
    target: int = 1,
    frame_of: int = mavlink.MAV_FRAME_LOCAL_NED,
    x: float = 1.0,
) -> Message:
    """Position (x, 2, 3), velocity (4, 5, 6), acceleration (7, 8, 9), yaw 0.5."""
    return mavlink.MAVLink_set_position_target_local_ned_message(
        123456, target, 1, frame_of, mask, x, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 9.0, 0.5, 0.0
    )
