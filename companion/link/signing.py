"""Frames that only who has the key can make: https://mavlink.io/en/guide/message_signing.html.

A signature is looked at before anything that a frame says is believed, its timestamp above all: a forged
timestamp of the far future would otherwise shut out every valid frame behind it.
"""

import hashlib
import hmac
from collections import Counter
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from enum import StrEnum
from typing import TypeAlias

from companion import clock
from companion.link.framing import Frame, marked_signed

Stream: TypeAlias = tuple[int, int, int]
"""System, component and link id of a signer."""

TICKS_PER_S = 100_000
LAST_TIMESTAMP = 2**48 - 1
LARGEST_STREAMS = 256
_UNIX_TIME_2015_S = 1_420_070_400
_LATEST_NEW_STREAM = 60 * TICKS_PER_S
_MAC_LENGTH = 6
_LINK_ID_AT, _TIMESTAMP_AT = -13, -12
_LINK_ID = bytes(1)


@dataclass(frozen=True, slots=True)
class SigningKey:
    """A key that the vehicle has too.

    Attributes:
        secret: 32 bytes.
    """

    secret: bytes = field(repr=False)

    @property
    def fingerprint(self) -> str:
        """A name for the key that does not give it away."""
        return hashlib.sha256(b"fingerprint of " + self.secret).hexdigest()[:16]


class Rejection(StrEnum):
    """Why a frame is not believed."""

    UNSIGNED = "unsigned"
    WRONGLY_SIGNED = "wrongly signed"
    REPLAYED = "replayed"
    STALE = "stale"
    TOO_MANY_STREAMS = "of too many signers"

    @property
    def is_authentic(self) -> bool:
        """Whether who made the frame has the key; it may have come from someone else all the same."""
        return self not in (Rejection.UNSIGNED, Rejection.WRONGLY_SIGNED)


class Signer:
    """Signs what is sent, and judges what is received.

    Args:
        key: the key.
        now: the clock that timestamps are taken from (10 µs since 2015); it may be wrong, and stand still.
        timestamp: the highest that was ever sent or believed.
        streams: the newest timestamp that was believed, of each stream.

    Attributes:
        rejected: how many frames were not believed, and why.
    """

    def __init__(
        self,
        key: SigningKey,
        now: Callable[[], int],
        timestamp: int = 0,
        streams: Mapping[Stream, int] | None = None,
    ) -> None:
        self.timestamp = timestamp
        self.streams = dict(streams or {})
        self.rejected: Counter[Rejection] = Counter()
        self._secret = key.secret
        self._now = now

    def sign(self, data: bytes) -> bytes:
        """The unsigned MAVLink 2 frame `data`, signed: later than any that was signed or believed before."""
        self.timestamp = min(max(self.timestamp + 1, self._now()), LAST_TIMESTAMP)
        content = marked_signed(data) + _LINK_ID + self.timestamp.to_bytes(6, "little")
        return content + self._mac(content)

    def rejection(self, frame: Frame) -> Rejection | None:
        """Why `frame` is not to be believed; None when it is."""
        rejection = self._judge(frame)
        if rejection is not None:
            self.rejected[rejection] += 1
        return rejection

    def _judge(self, frame: Frame) -> Rejection | None:
        if not frame.signed:
            return Rejection.UNSIGNED
        data = frame.data
        if not hmac.compare_digest(self._mac(data[:-_MAC_LENGTH]), data[-_MAC_LENGTH:]):
            return Rejection.WRONGLY_SIGNED
        stream = (frame.system_id, frame.component_id, data[_LINK_ID_AT])
        timestamp = int.from_bytes(data[_TIMESTAMP_AT:-_MAC_LENGTH], "little")
        newest = self.streams.get(stream)
        if newest is None:
            if timestamp < max(self.timestamp, self._now()) - _LATEST_NEW_STREAM:
                return Rejection.STALE
            if len(self.streams) >= LARGEST_STREAMS:
                return Rejection.TOO_MANY_STREAMS
        elif timestamp <= newest:
            return Rejection.REPLAYED
        self.streams[stream] = timestamp
        self.timestamp = max(self.timestamp, timestamp)
        return None

    def _mac(self, content: bytes) -> bytes:
        return hashlib.sha256(self._secret + content).digest()[:_MAC_LENGTH]


def ticks_since_2015() -> Callable[[], int]:
    """A clock for signatures: set by the wall's clock once, and running evenly from then on."""
    ahead_s = clock.unix_time_s() - _UNIX_TIME_2015_S - clock.now()
    return lambda: int((ahead_s + clock.now()) * TICKS_PER_S)
