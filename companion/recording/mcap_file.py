"""A recording as one MCAP file, which Foxglove and PlotJuggler open as it is.

Three channels of JSON messages with a JSON schema hold the three series, a message a row: `/state`,
`/reference` and `/tracking`. `/events` holds what happened in words, the metadata record `provenance`
what the recording is of, and `segments` which parts of it have a name. Vectors are objects (`position.x`),
so that a viewer names its curves by itself.

Time: `time_s` of a message is the recording's clock, to the last bit; `log_time` and `publish_time` are the
same instant in whole nanoseconds. That clock's zero has no meaning: no file knows the time of day.

NaN, which JSON does not have, is a component left out; viewers that follow the schema refuse `null`.
Chunks are complete in themselves, so a file that was cut is read up to its last whole chunk.

Format: https://mcap.dev/spec
"""

import dataclasses
import heapq
import io
import json
import math
import struct
from array import array
from collections.abc import Callable, Iterable, Iterator, Sequence
from operator import itemgetter
from pathlib import Path
from types import TracebackType
from typing import Any, Self, TypeAlias

import numpy as np
import zstandard
from mcap.exceptions import McapError
from mcap.records import Channel, Chunk, DataEnd, McapRecord, Message, Metadata, Schema
from mcap.stream_reader import StreamReader, breakup_chunk
from mcap.writer import Writer
from pydantic import TypeAdapter

from companion.arrays import Vec3
from companion.errors import InputError
from companion.recording.bounded_file import MAX_BYTES, read_bytes, too_large
from companion.recording.segments import Segment, Window
from companion.recording.series import (
    Provenance,
    Recording,
    ReferenceSeries,
    Series,
    StateSeries,
    TrackingSeries,
)

Row: TypeAlias = tuple[float, Callable[..., None], Sequence[object]]
"""A message to be: its time (s), the method that adds it, and what that takes besides the time."""

SERIES = {"/state": StateSeries, "/reference": ReferenceSeries, "/tracking": TrackingSeries}
EVENTS = "/events"
PROVENANCE = "provenance"
SEGMENTS = "segments"

SEGMENT_LIST = TypeAdapter(tuple[Segment, ...])
HOVER = TypeAdapter(Window | None)

NOT_XYZ = {"attitude": ("roll", "pitch", "yaw"), "rates": ("p", "q", "r"), "yaw": ()}
"""Columns whose components have names of their own, or that are mere numbers and have none."""

UNREADABLE = (
    *(McapError, struct.error, zstandard.ZstdError),
    *(ValueError, KeyError, TypeError, AttributeError, OverflowError, RecursionError),
)
"""What the libraries beneath raise on bytes that are no MCAP file, or half of one."""


def _columns(topic: str) -> dict[str, tuple[str, ...]]:
    """Names of a topic's columns, in order, with the names of their components."""
    names = [field.name for field in dataclasses.fields(SERIES[topic])]
    return {name: NOT_XYZ.get(name, ("x", "y", "z")) for name in names if name != "time_s"}


COLUMNS = {topic: _columns(topic) for topic in SERIES}


def _schema_name(topic: str) -> str:
    return f"impromptu.{topic.removeprefix('/').capitalize()}"


def _json_schema(topic: str) -> dict[str, object]:
    number = {"type": "number"}
    properties: dict[str, object] = {"time_s": number}
    if topic == EVENTS:
        properties["text"] = {"type": "string"}
    else:
        for name, components in COLUMNS[topic].items():
            parts = {"type": "object", "properties": dict.fromkeys(components, number)}
            properties[name] = parts if components else number
    return {
        "title": _schema_name(topic),
        "description": "NED, metres, seconds, radians; time_s is the recording's clock",
        "type": "object",
        "properties": properties,
        "required": [name for name in properties if NOT_XYZ.get(name) != ()],
    }


class McapWriter:
    """Writes a recording message by message; use it as a context manager.

    Rows may come in any order, and are read back, a series each, in the order in which they came.
    All vectors are in the frame and units of `companion.recording.series`; times are finite and not
    negative (s).

    Raises:
        InputError: when the file cannot be written.
    """

    def __init__(self, path: Path, provenance: Provenance) -> None:
        try:
            self._file = path.open("wb")
        except OSError as error:
            raise InputError(f"{path}: cannot be written ({error.strerror})") from error
        self._writer = Writer(self._file, enable_data_crcs=True)
        self._writer.start(library=f"impromptu {provenance.software}".rstrip())
        self._add_metadata(PROVENANCE, provenance.model_dump(mode="json"))
        self._channels = {topic: self._register(topic) for topic in (*SERIES, EVENTS)}

    def _register(self, topic: str) -> int:
        schema = json.dumps(_json_schema(topic)).encode()
        schema_id = self._writer.register_schema(_schema_name(topic), "jsonschema", schema)
        return self._writer.register_channel(topic, "json", schema_id)

    def add_state(self, time_s: float, position: Vec3, velocity: Vec3, attitude: Vec3, rates: Vec3) -> None:
        """Add a row of `StateSeries`."""
        self._add_row("/state", time_s, (position, velocity, attitude, rates))

    def add_reference(
        self, time_s: float, position: Vec3, velocity: Vec3, acceleration: Vec3, yaw: float
    ) -> None:
        """Add a row of `ReferenceSeries`."""
        self._add_row("/reference", time_s, (position, velocity, acceleration, yaw))

    def add_tracking(
        self,
        time_s: float,
        desired_position: Vec3,
        desired_velocity: Vec3,
        desired_acceleration: Vec3,
        u1: Vec3,
        u2: Vec3,
        predicted_position: Vec3,
        predicted_variance: Vec3,
        alpha: Vec3,
    ) -> None:
        """Add a row of `TrackingSeries`."""
        desired = (desired_position, desired_velocity, desired_acceleration)
        self._add_row("/tracking", time_s, (*desired, u1, u2, predicted_position, predicted_variance, alpha))

    def add_event(self, time_s: float, text: str) -> None:
        """Add what happened at `time_s`, in words."""
        self._add(EVENTS, time_s, {"text": text})

    def add_segments(self, segments: tuple[Segment, ...], hover: Window | None) -> None:
        """Add the parts that have a name; a later call takes the place of an earlier one."""
        parts = {"segments": SEGMENT_LIST.dump_python(segments), "hover": HOVER.dump_python(hover)}
        self._add_metadata(SEGMENTS, parts)

    def flush(self) -> None:
        """End the chunk and hand everything so far to the system: what is lost in a crash comes later."""
        self._writer.flush()  # type: ignore[no-untyped-call]

    def close(self) -> None:
        """Write the index that lets viewers jump, and close the file; a second call does nothing."""
        if not self._file.closed:
            self._writer.finish()  # type: ignore[no-untyped-call]
            self._file.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def _add_metadata(self, name: str, values: dict[str, object]) -> None:
        self._writer.add_metadata(name, {key: json.dumps(value) for key, value in values.items()})

    def _add_row(self, topic: str, time_s: float, values: Iterable[Vec3 | float]) -> None:
        fields: dict[str, object] = {}
        for (name, components), value in zip(COLUMNS[topic].items(), values, strict=True):
            if isinstance(value, float):
                fields |= _finite((name,), (value,))
            else:
                fields[name] = _finite(components, value.tolist())
        self._add(topic, time_s, fields)

    def _add(self, topic: str, time_s: float, fields: dict[str, object]) -> None:
        nanoseconds = round(time_s * 1e9)
        body = json.dumps({"time_s": float(time_s), **fields}).encode()
        self._writer.add_message(self._channels[topic], nanoseconds, body, nanoseconds)


def _finite(names: Iterable[str], numbers: Iterable[float]) -> dict[str, float]:
    return {name: number for name, number in zip(names, numbers, strict=True) if math.isfinite(number)}


def write_recording(recording: Recording, path: Path) -> None:
    """Write `recording` to `path` (MCAP), its messages in the order of their times.

    Raises:
        InputError: when the file cannot be written.
    """
    with McapWriter(path, recording.provenance) as writer:
        if recording.segments or recording.hover:
            writer.add_segments(recording.segments, recording.hover)
        rows: list[Iterator[Row]] = [
            _rows(recording.states, writer.add_state),
            _rows(recording.references, writer.add_reference),
            ((time_s, writer.add_event, (text,)) for time_s, text in recording.events),
        ]
        if recording.tracking is not None:
            rows.append(_rows(recording.tracking, writer.add_tracking))
        for time_s, add, columns in heapq.merge(*rows, key=itemgetter(0)):
            add(time_s, *columns)


def _rows(series: Series, add: Callable[..., None]) -> Iterator[Row]:
    columns = [getattr(series, field.name) for field in dataclasses.fields(series)]
    for time_s, *values in zip(*columns, strict=True):
        yield time_s, add, values


class _Contents:
    """What has been read so far: flat rows of numbers for each topic, 8 bytes a number."""

    def __init__(self) -> None:
        self.provenance: Provenance | None = None
        self.segments: tuple[Segment, ...] = ()
        self.hover: Window | None = None
        self.times = {topic: array("d") for topic in SERIES}
        self.events: list[tuple[float, str]] = []
        self._numbers = {topic: array("d") for topic in SERIES}
        self._schemas: dict[int, str] = {}
        self._topics: dict[int, str] = {}

    def take(self, record: McapRecord) -> None:
        """Take in one record."""
        match record:
            case Schema():
                self._schemas[record.id] = record.name
            case Channel():
                known = record.topic in (*SERIES, EVENTS)
                if known and self._schemas.get(record.schema_id) == _schema_name(record.topic):
                    self._topics[record.id] = record.topic
            case Message():
                if (topic := self._topics.get(record.channel_id)) is not None:
                    self._take_message(topic, json.loads(record.data))
            case Metadata() if record.name == PROVENANCE:
                values = {key: json.loads(value) for key, value in record.metadata.items()}
                self.provenance = Provenance.model_validate(values)
            case Metadata() if record.name == SEGMENTS:
                self.segments = SEGMENT_LIST.validate_json(record.metadata["segments"])
                self.hover = HOVER.validate_json(record.metadata["hover"])

    def _take_message(self, topic: str, message: dict[str, Any]) -> None:
        time_s = message["time_s"]
        if not math.isfinite(time_s):
            raise ValueError("time_s is not finite")
        if topic == EVENTS:
            self.events.append((time_s, str(message["text"])))
            return
        numbers: list[float] = []
        for name, components in COLUMNS[topic].items():
            values, names = (message[name], components) if components else (message, (name,))
            numbers += [values.get(part, math.nan) for part in names]
        self._numbers[topic].extend(array("d", numbers))
        self.times[topic].append(time_s)

    def series(self, topic: str, kind: type[Series]) -> Series:
        """The rows of `topic` as a series."""
        widths = [max(1, len(components)) for components in COLUMNS[topic].values()]
        table = np.array(self._numbers[topic]).reshape(-1, sum(widths))
        parts = np.split(table, np.cumsum(widths)[:-1], axis=1)
        columns = {
            name: part.copy() if components else part[:, 0].copy()
            for (name, components), part in zip(COLUMNS[topic].items(), parts, strict=True)
        }
        return kind(time_s=np.array(self.times[topic]), **columns)


def read_mcap(path: Path) -> Recording:
    """Read a recording from an MCAP file of this layout; other channels in it are passed over.

    A file that was cut short gives what is left of it, and an event at its end says so.

    Raises:
        InputError: when the file cannot be read, is no recording, is damaged or is too large.
    """
    file = io.BytesIO(read_bytes(path))  # unlike a file, it never allocates what a length field claims
    contents = _Contents()
    whole = _read_into(contents, file, path)
    if contents.provenance is None:
        raise InputError(f"{path}: no recording of Impromptu: an MCAP file with its provenance was expected")
    if not whole:
        last_s = max((rows[-1] for rows in contents.times.values() if rows), default=0.0)
        contents.events.append((last_s, f"the recording ends here: {path.name} was cut short"))
    tracking = contents.series("/tracking", TrackingSeries)
    return Recording(
        provenance=contents.provenance,
        states=contents.series("/state", StateSeries),
        references=contents.series("/reference", ReferenceSeries),
        tracking=tracking if len(tracking.time_s) else None,
        events=tuple(contents.events),
        segments=contents.segments,
        hover=contents.hover,
    )


def _read_into(contents: _Contents, file: io.BytesIO, path: Path) -> bool:
    """Fill `contents` from `file`; False when the file ends before its data do."""
    try:
        for record in _records(file, path):
            contents.take(record)
    except UNREADABLE as error:
        damaged_before = file.tell()
        if file.read(1):
            raise InputError(f"{path}: damaged before byte {damaged_before}, or no MCAP file") from error
        return False
    return True


def _records(file: io.BytesIO, path: Path) -> Iterator[McapRecord]:
    """The records of the data section, those inside chunks too, each chunk checked against its CRC."""
    unpacked = 0
    reader = StreamReader(file, emit_chunks=True, validate_crcs=True)
    for record in reader.records:
        match record:
            case Chunk():
                unpacked += _unpacked_size(record)
                if unpacked > MAX_BYTES:
                    raise too_large(path)
                yield from breakup_chunk(record, validate_crc=True)
            case DataEnd():
                return
            case _:
                yield record


def _unpacked_size(chunk: Chunk) -> int:
    """What unpacking `chunk` will take (bytes)."""
    if chunk.compression == "zstd":
        size = zstandard.get_frame_parameters(chunk.data).content_size
        if size not in (chunk.uncompressed_size, zstandard.CONTENTSIZE_UNKNOWN):
            raise ValueError(f"chunk of {size} bytes, not {chunk.uncompressed_size}")
    elif chunk.compression:
        raise ValueError(f"compression {chunk.compression!r}")
    return chunk.uncompressed_size
