"""What the vehicle says in words: STATUSTEXT, its chunks joined, the newest kept."""

import math
import zlib
from collections import deque
from collections.abc import Callable, Iterator
from dataclasses import dataclass

from companion import clock
from companion.link.dialect import mavlink

_KEPT = 200
_LONGEST_CHUNK = 50
"""Characters in a STATUSTEXT; a shorter one ends its text."""
_MOST_UNFINISHED = 4
_PATIENCE_S = 1.0
"""How far apart the chunks of a text may come."""
_TWICE_S = 0.5
"""The same line again within this time came on two ways."""


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


def status_text(severity: int, text: str) -> list[mavlink.MAVLink_statustext_message]:
    """A text of ours as messages: one, or chunks, which an id tells from those of other texts."""
    data = text.encode("ascii", errors="replace")
    if len(data) <= _LONGEST_CHUNK:
        return [mavlink.MAVLink_statustext_message(severity, data)]
    text_id = zlib.crc32(data) % 0xFFFF + 1
    starts = range(0, len(data) + 1, _LONGEST_CHUNK)
    chunks = [data[start : start + _LONGEST_CHUNK] for start in starts]
    return [
        mavlink.MAVLink_statustext_message(severity, chunk, text_id, place)
        for place, chunk in enumerate(chunks)
    ]


class StatusTexts:
    """The newest lines, oldest first; tells subscribers of each as it comes."""

    def __init__(self) -> None:
        self._lines: deque[StatusText] = deque(maxlen=_KEPT)
        self._handlers: tuple[Callable[[StatusText], None], ...] = ()
        self._unfinished: dict[int, _Chunks] = {}
        self._finished: deque[tuple[int, float]] = deque(maxlen=_MOST_UNFINISHED)

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
        self._finish_all(since_s=math.inf)
        warnings = (line for line in self._lines if line.severity <= mavlink.MAV_SEVERITY_WARNING)
        return list(dict.fromkeys(line.text for line in warnings if line.received_s >= time_s))

    def add(self, message: mavlink.MAVLink_statustext_message) -> None:
        """Take one message: a text, or a chunk of one, in whatever order they come."""
        if message.id == 0:
            self._say(message.severity, message.text)
            return
        now_s = clock.now()
        if any(message.id == past and now_s - then_s < _PATIENCE_S for past, then_s in self._finished):
            return
        if message.id not in self._unfinished and len(self._unfinished) == _MOST_UNFINISHED:
            self._finish(next(iter(self._unfinished)))
        chunks = self._unfinished.setdefault(message.id, _Chunks(now_s, {}))
        chunks.by_place.setdefault(message.chunk_seq, message)
        if chunks.complete:
            self._finish(message.id)

    def finish_old(self) -> None:
        """Make lines of the chunks whose others must have been lost."""
        self._finish_all(since_s=clock.now() - _PATIENCE_S)

    def _finish_all(self, since_s: float) -> None:
        for text_id in [text_id for text_id, chunks in self._unfinished.items() if chunks.begun_s <= since_s]:
            self._finish(text_id)

    def _finish(self, text_id: int) -> None:
        chunks = self._unfinished.pop(text_id)
        self._finished.append((text_id, clock.now()))
        self._say(chunks.severity, chunks.text)

    def _say(self, severity: int, text: str) -> None:
        now_s = clock.now()
        for line in reversed(self._lines):
            if now_s - line.received_s > _TWICE_S:
                break
            if (line.severity, line.text) == (severity, text):
                return
        line = StatusText(now_s, severity, text)
        self._lines.append(line)
        for handler in self._handlers:
            handler(line)


@dataclass(frozen=True, slots=True)
class _Chunks:
    """What has come of a long text since `begun_s` (companion clock, s)."""

    begun_s: float
    by_place: dict[int, mavlink.MAVLink_statustext_message]

    @property
    def complete(self) -> bool:
        last = max(self.by_place)
        return len(self.by_place[last].text) < _LONGEST_CHUNK and len(self.by_place) == last + 1

    @property
    def severity(self) -> int:
        return next(iter(self.by_place.values())).severity

    @property
    def text(self) -> str:
        """All of it; gaps show where chunks were lost."""
        last = max(self.by_place)
        text = ""
        for place in range(last + 1):
            if place in self.by_place:
                text += self.by_place[place].text
            elif not text.endswith("…"):
                text += "…"
        return text + ("…" if len(self.by_place[last].text) == _LONGEST_CHUNK else "")
