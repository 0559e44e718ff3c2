"""What the vehicle says in words: STATUSTEXT, its chunks joined, the newest kept."""

from collections import deque
from collections.abc import Callable, Iterator
from dataclasses import dataclass

from companion import clock
from companion.link.dialect import mavlink

_KEPT = 200
_LONGEST_CHUNK = 50
"""Characters in a STATUSTEXT; a shorter one ends its text."""


@dataclass(frozen=True, slots=True)
class StatusText:
    """One line from the vehicle.

    Attributes:
        received_s: companion clock at which it was complete (s).
        severity: MAV_SEVERITY, 0 (emergency) to 7 (debug).
        text: the line.
    """

    received_s: float
    severity: int
    text: str


class StatusTexts:
    """The newest lines, oldest first; tells subscribers of each as it comes."""

    def __init__(self) -> None:
        self._lines: deque[StatusText] = deque(maxlen=_KEPT)
        self._handlers: tuple[Callable[[StatusText], None], ...] = ()
        self._chunks: list[str] = []
        self._chunks_id = 0

    def __iter__(self) -> Iterator[StatusText]:
        return iter(tuple(self._lines))

    def subscribe(self, handler: Callable[[StatusText], None]) -> Callable[[], None]:
        """Call `handler` with each line from now on; returns what ends that."""
        self._handlers += (handler,)

        def unsubscribe() -> None:
            self._handlers = tuple(other for other in self._handlers if other is not handler)

        return unsubscribe

    def warnings_since(self, time_s: float) -> list[str]:
        """The lines since `time_s` (companion clock, s) that were no mere information; each once."""
        return list(
            dict.fromkeys(
                line.text
                for line in self._lines
                if line.received_s >= time_s and line.severity <= mavlink.MAV_SEVERITY_WARNING
            )
        )

    def add(self, message: mavlink.MAVLink_statustext_message) -> None:
        """Take one message; a text of several chunks is complete with its last."""
        if message.id != self._chunks_id or message.chunk_seq == 0:
            self._chunks = []
        self._chunks_id = message.id
        self._chunks.append(message.text)
        if message.id != 0 and len(message.text) == _LONGEST_CHUNK:
            return
        line = StatusText(clock.now(), message.severity, "".join(self._chunks))
        self._chunks = []
        self._lines.append(line)
        for handler in self._handlers:
            handler(line)
