"""A whole recording as one MCAP file, and back; a flight's file is written by `flight_log` meanwhile."""

import dataclasses
import heapq
import json
from collections.abc import Iterator
from operator import itemgetter
from pathlib import Path
from typing import TypeAlias

from companion.errors import InputError
from companion.recording import topics
from companion.recording.collected import HOVER, SEGMENT_LIST, Collected
from companion.recording.mcap_reader import UNREADABLE, Attachment, CutShort, Message, Metadata, read_items
from companion.recording.mcap_writer import McapWriter
from companion.recording.series import Recording, Series
from companion.recording.topics import EVENTS, REFERENCE, SEGMENTS, STATE, TRACKING, Fields

Timed: TypeAlias = tuple[float, str, Fields]


def write_recording(recording: Recording, path: Path) -> None:
    """Write `recording` to `path` (MCAP), its messages in the order of their times.

    Dates are those of a clock whose zero is 1970: no recording knows the time of day.

    Raises:
        InputError: when the file cannot be written.
    """
    try:
        with path.open("wb") as file:
            writer = McapWriter(file, recording.provenance)
            if recording.segments or recording.hover:
                writer.add_metadata(SEGMENTS, _parts(recording))
            messages = [
                _rows(STATE, recording.states),
                _rows(REFERENCE, recording.references),
                _events(recording, writer),
            ]
            if recording.tracking is not None:
                messages.append(_rows(TRACKING, recording.tracking))
            for time_s, topic, fields in heapq.merge(*messages, key=itemgetter(0)):
                writer.add(topic, time_s, fields)
            writer.finish()
    except OSError as error:
        raise InputError(f"{path}: cannot be written ({error.strerror})") from error


def read_mcap(path: Path) -> Recording:
    """Read a recording from an MCAP file of our layout; other channels in it are passed over.

    A file that was cut short gives what is left of it, and an event at its end says so.

    Raises:
        InputError: when the file cannot be read, is no recording, is damaged or is too large.
    """
    collected = Collected()
    whole = True
    for item in read_items(path):
        match item:
            case CutShort():
                whole = False
            case Attachment():
                pass
            case _:
                _collect(item, collected, path)
    if collected.provenance is None:
        raise InputError(f"{path}: no recording of Impromptu, or cut off before anything was in it")
    if not whole:
        collected.events.append((collected.last_s, f"the recording ends here: {path.name} was cut short"))
    return dataclasses.replace(collected.recording(collected.provenance), whole=whole)


def _collect(item: Message | Metadata, collected: Collected, path: Path) -> None:
    try:
        if isinstance(item, Metadata):
            collected.add_metadata(item.name, item.values)
        else:
            collected.add(item.topic, item.time_s, item.fields)
    except UNREADABLE as error:
        what = item.name if isinstance(item, Metadata) else f"{item.topic} at {item.time_s} s"
        raise InputError(f"{path}: damaged: {what} is not what it should be") from error


def _parts(recording: Recording) -> dict[str, object]:
    segments = json.loads(SEGMENT_LIST.dump_json(recording.segments))
    return {"segments": segments, "hover": json.loads(HOVER.dump_json(recording.hover))}


def _rows(topic: str, series: Series) -> Iterator[Timed]:
    names = [field.name for field in dataclasses.fields(series)]
    for time_s, *values in zip(*(getattr(series, name) for name in names), strict=True):
        yield time_s, topic, topics.row(topic, dict(zip(names[1:], values, strict=True)))


def _events(recording: Recording, writer: McapWriter) -> Iterator[Timed]:
    for time_s, text in recording.events:
        yield time_s, EVENTS, topics.event(writer.unix_ns(time_s), text)
