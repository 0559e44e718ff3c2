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
        self._chunks: list[mavlink.MAVLink_statustext_message] = []

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
        self._finish()
        warnings = (line for line in self._lines if line.severity <= mavlink.MAV_SEVERITY_WARNING)
        return list(dict.fromkeys(line.text for line in warnings if line.received_s >= time_s))

    def add(self, message: mavlink.MAVLink_statustext_message) -> None:
        """Take one message: a chunk of a text, or all of it."""
        if self._chunks and message.id != self._chunks[0].id:
            self._finish()
        self._chunks.append(message)
        if message.id == 0 or len(message.text) < _LONGEST_CHUNK:
            self._finish()

    def _finish(self) -> None:
        """Make a line of the chunks that came; gaps show where some were lost."""
        if not self._chunks:
            return
        text, expected = "", 0
        for chunk in self._chunks:
            text += ("" if chunk.chunk_seq == expected else "…") + chunk.text
            expected = chunk.chunk_seq + 1
        last = self._chunks[-1]
        if last.id != 0 and len(last.text) == _LONGEST_CHUNK:
            text += "…"
        self._chunks.clear()
        line = StatusText(clock.now(), last.severity, text)
        self._lines.append(line)
        for handler in self._handlers:
            handler(line)
