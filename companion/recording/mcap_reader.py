"""Messages from MCAP files of our layout, whole or cut at any byte.

A file is read from its beginning, chunk after chunk, and neither its index nor its end is asked for. What
another program put into it is passed over.
"""

import io
import json
import math
import struct
from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple, TypeAlias

import zstandard
from mcap import records as mcap
from mcap.exceptions import McapError
from mcap.records import McapRecord
from mcap.stream_reader import StreamReader, breakup_chunk

from companion.errors import InputError
from companion.recording.bounded_file import MAX_BYTES, read_bytes, too_large
from companion.recording.topics import EVENTS, METADATA, OLD_EVENTS, TOPICS, Fields, schema_name

UNREADABLE = (
    *(McapError, struct.error, zstandard.ZstdError),
    *(ValueError, KeyError, TypeError, AttributeError, OverflowError, RecursionError),
)
"""What the libraries beneath raise on bytes that are no MCAP file, or half of one."""


class Message(NamedTuple):
    """A message of `companion.recording.topics`, at `time_s` of the recording's clock (s)."""

    topic: str
    time_s: float
    fields: Fields


class Metadata(NamedTuple):
    """What is known once."""

    name: str
    values: dict[str, Any]


class Attachment(NamedTuple):
    """Bytes that messages refer to."""

    name: str
    data: bytes


class CutShort(NamedTuple):
    """The file ends before its data do."""


Item: TypeAlias = Message | Metadata | Attachment | CutShort


def read_items(path: Path) -> Iterator[Item]:
    """What is in the file, in the order in which it was written.

    Raises:
        InputError: the file cannot be read, is damaged, is no MCAP file or too large.
    """
    file = io.BytesIO(read_bytes(path))  # unlike a file, it never allocates what a length field claims
    items = _items(_records(file, path))
    while True:
        try:
            item = next(items)
        except StopIteration:
            return
        except UNREADABLE as error:
            damaged_before = file.tell()
            # Where power was cut, some file systems leave zeros for what they had not written yet.
            if file.read().strip(b"\0"):
                raise InputError(f"{path}: damaged before byte {damaged_before}, or no MCAP file") from error
            item = CutShort()
        yield item


def _items(records: Iterator[McapRecord]) -> Iterator[Item]:
    schemas: dict[int, str] = {}
    channels: dict[int, tuple[str, str]] = {}
    for record in records:
        match record:
            case mcap.Schema():
                schemas[record.id] = record.name
            case mcap.Channel():
                channels[record.id] = record.topic, schemas.get(record.schema_id, "")
            case mcap.Message():
                topic, schema = channels[record.channel_id]
                if topic in TOPICS and schema in (schema_name(topic), OLD_EVENTS):
                    yield _message(topic, schema, json.loads(record.data))
            case mcap.Metadata() if record.name in METADATA:
                values = {key: json.loads(value) for key, value in record.metadata.items()}
                yield Metadata(record.name, values)
            case mcap.Attachment():
                yield Attachment(record.name, record.data)


def _message(topic: str, schema: str, fields: Fields) -> Message:
    if topic == EVENTS and schema == OLD_EVENTS:
        fields["message"] = fields.pop("text")
    time_s = fields.pop("time_s")
    if not math.isfinite(time_s):
        raise ValueError("time_s is not finite")
    return Message(topic, time_s, fields)


def _records(file: io.BytesIO, path: Path) -> Iterator[McapRecord]:
    """The records of the data section, those inside chunks too, each chunk checked against its CRC."""
    unpacked = 0
    reader = StreamReader(file, emit_chunks=True, validate_crcs=True)
    for record in reader.records:
        match record:
            case mcap.Chunk():
                unpacked += _unpacked_size(record)
                if unpacked > MAX_BYTES:
                    raise too_large(path)
                yield from breakup_chunk(record, validate_crc=True)
            case mcap.DataEnd():
                return
            case _:
                yield record


def _unpacked_size(chunk: mcap.Chunk) -> int:
    """What unpacking `chunk` will take (bytes)."""
    if chunk.compression == "zstd":
        size = zstandard.get_frame_parameters(chunk.data).content_size
        if size not in (chunk.uncompressed_size, zstandard.CONTENTSIZE_UNKNOWN):
            raise ValueError(f"chunk of {size} bytes, not {chunk.uncompressed_size}")
    elif chunk.compression:
        raise ValueError(f"compression {chunk.compression!r}")
    return chunk.uncompressed_size
