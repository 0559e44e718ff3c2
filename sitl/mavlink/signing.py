"""The vehicle's side of signed links: https://mavlink.io/en/guide/message_signing.html."""

import hashlib
import hmac

from pymavlink.dialects.v20 import common as mavlink

from sitl.mavlink.frames import Message

_NEW_STREAM_BEHIND = 6_000_000
"""How far a new stream may be behind (10 µs): one minute."""
_MAC_LENGTH = 6
_LINK_ID_AT, _TIMESTAMP_AT = -13, -12


class Signing:
    """Knows the key (32 bytes) and the time of the signatures on all links of one vehicle.

    That time is the latest that was heard, and 2015 before: that of an autopilot without satellites, which
    tells nobody to wait for it.
    """

    def __init__(self, key: bytes) -> None:
        self.key = key
        self._timestamp = 0
        self._newest: dict[tuple[int, int, int], int] = {}

    def next_timestamp(self) -> int:
        """That of the next frame to be signed (10 µs since 2015)."""
        self._timestamp += 1
        return self._timestamp

    def believes(self, message: Message) -> bool:
        """Whether the frame of `message` was signed with the key, and later than the last of its stream."""
        frame = bytes(message.get_msgbuf())
        if frame[0] != mavlink.PROTOCOL_MARKER_V2 or not frame[2] & mavlink.MAVLINK_IFLAG_SIGNED:
            return False
        code = hashlib.sha256(self.key + frame[:-_MAC_LENGTH]).digest()[:_MAC_LENGTH]
        if not hmac.compare_digest(code, frame[-_MAC_LENGTH:]):
            return False
        stream = (message.get_srcSystem(), message.get_srcComponent(), frame[_LINK_ID_AT])
        timestamp = int.from_bytes(frame[_TIMESTAMP_AT:-_MAC_LENGTH], "little")
        if timestamp <= self._newest.get(stream, self._timestamp - _NEW_STREAM_BEHIND - 1):
            return False
        self._newest[stream] = timestamp
        self._timestamp = max(self._timestamp, timestamp)
        return True
