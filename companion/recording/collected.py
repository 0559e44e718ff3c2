"""Messages, collected as a recording."""

import math
from array import array
from typing import Any

import numpy as np
from pydantic import TypeAdapter

from companion.recording.segments import Segment, Window
from companion.recording.series import (
    Provenance,
    Recording,
    ReferenceSeries,
    Series,
    StateSeries,
    TrackingSeries,
)
from companion.recording.topics import (
    COLUMNS,
    CONFIGURATION,
    EVENTS,
    PROVENANCE,
    REFERENCE,
    SEGMENTS,
    SERIES,
    STATE,
    TRACKING,
    VERSIONS,
    Fields,
)

SEGMENT_LIST = TypeAdapter(tuple[Segment, ...])
HOVER = TypeAdapter(Window | None)


class Collected:
    """A `Sink` in memory: flat rows of numbers for each series, 8 bytes a number.

    Messages that belong to no series, and attachments, are passed over.

    Attributes:
        provenance: what the recording is of, where it said so.
        segments, hover: the parts that have a name.
        made_by: the command and the versions, by name.
        events: what happened, in words.

    Raises:
        ValueError, KeyError, TypeError, AttributeError: a message is none of its topic.
    """

    def __init__(self) -> None:
        self.provenance: Provenance | None = None
        self.segments: tuple[Segment, ...] = ()
        self.hover: Window | None = None
        self.made_by: dict[str, str] = {}
        self.events: list[tuple[float, str]] = []
        self._times = {topic: array("d") for topic in SERIES}
        self._numbers = {topic: array("d") for topic in SERIES}

    def add(self, topic: str, time_s: float, fields: Fields) -> None:
        """Take in a message."""
        if topic == EVENTS:
            self.events.append((time_s, str(fields["message"])))
        if topic not in SERIES:
            return
        numbers: list[float] = []
        for name, components in COLUMNS[topic].items():
            values, names = (fields[name], components) if components else (fields, (name,))
            numbers += [values.get(part, math.nan) for part in names]
        self._numbers[topic].extend(array("d", numbers))
        self._times[topic].append(time_s)

    def add_metadata(self, name: str, values: dict[str, Any]) -> None:
        """Take in provenance and segments, the command and the versions."""
        if name == PROVENANCE:
            self.provenance = Provenance.model_validate(values)
        elif name == SEGMENTS:
            self.segments = SEGMENT_LIST.validate_python(values["segments"])
            self.hover = HOVER.validate_python(values["hover"])
        elif name == VERSIONS:
            self.made_by |= {key: str(value) for key, value in values.items()}
        elif name == CONFIGURATION:
            self.made_by["command"] = str(values.get("command", ""))

    def attach(self, name: str, data: bytes) -> None:
        """No series needs it."""

    @property
    def last_s(self) -> float:
        """The newest instant of any series (s); 0 where there is none."""
        return max((times[-1] for times in self._times.values() if times), default=0.0)

    def recording(self, provenance: Provenance) -> Recording:
        """All that was taken in so far."""
        tracking = self._series(TRACKING, TrackingSeries)
        return Recording(
            provenance=provenance,
            states=self._series(STATE, StateSeries),
            references=self._series(REFERENCE, ReferenceSeries),
            tracking=tracking if len(tracking.time_s) else None,
            events=tuple(self.events),
            segments=self.segments,
            hover=self.hover,
            made_by=self.made_by,
        )

    def _series(self, topic: str, kind: type[Series]) -> Series:
        widths = [max(1, len(components)) for components in COLUMNS[topic].values()]
        table = np.array(self._numbers[topic]).reshape(-1, sum(widths))
        parts = np.split(table, np.cumsum(widths)[:-1], axis=1)
        columns = {
            name: part.copy() if components else part[:, 0].copy()
            for (name, components), part in zip(COLUMNS[topic].items(), parts, strict=True)
        }
        return kind(time_s=np.array(self._times[topic]), **columns)
