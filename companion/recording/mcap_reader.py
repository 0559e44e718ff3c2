"""Messages from MCAP files of our layout, whole or cut at any byte.

A file is read from its beginning, chunk after chunk, and neither its index nor its end is asked for. What
another program put into it is passed over.
"""

import io
import json
import struct
from collections.abc import Iterator
from pathlib import Path

import zstandard
from mcap.exceptions import McapError
from mcap.records import Attachment, Channel, Chunk, DataEnd, McapRecord, Message, Metadata, Schema
from mcap.stream_reader import StreamReader, breakup_chunk

from companion.errors import InputError
from companion.recording.bounded_file import MAX_BYTES, read_bytes, too_large
from companion.recording.sink import Sink
from companion.recording.topics import EVENTS, METADATA, OLD_EVENTS, TOPICS, schema_name

UNREADABLE = (
    *(McapError, struct.error, zstandard.ZstdError),
    *(ValueError, KeyError, TypeError, AttributeError, OverflowError, RecursionError),
)
"""What the libraries beneath raise on bytes that are no MCAP file, or half of one."""


def read_messages(path: Path, sink: Sink) -> bool:
    """Give `sink` what is in the file, in the order in which it was written; False where the file was cut.

    What a sink makes of a message by raising one of `UNREADABLE` counts as damage.

    Raises:
        InputError: the file cannot be read, is damaged, is no MCAP file or too large.
    """
    file = io.BytesIO(read_bytes(path))  # unlike a file, it never allocates what a length field claims
    try:
        _Dispatch(sink).all(_records(file, path))
    except UNREADABLE as error:
        damaged_before = file.tell()
        # Where power was cut, some file systems leave zeros for what they had not written yet.
        if file.read().strip(b"\0"):
            raise InputError(f"{path}: damaged before byte {damaged_before}, or no MCAP file") from error
        return False
    return True


class _Dispatch:
    """Hands on records, by what is known of schemas and channels so far."""

    def __init__(self, sink: Sink) -> None:
        self._sink = sink
        self._schemas: dict[int, str] = {}
        self._channels: dict[int, tuple[str, str]] = {}

    def all(self, records: Iterator[McapRecord]) -> None:
        for record in records:
            match record:
                case Schema():
                    self._schemas[record.id] = record.name
                case Channel():
                    self._channels[record.id] = record.topic, self._schemas.get(record.schema_id, "")
                case Message():
                    self._message(record)
                case Metadata() if record.name in METADATA:
                    values = {key: json.loads(value) for key, value in record.metadata.items()}
                    self._sink.add_metadata(record.name, values)
                case Attachment():
                    self._sink.attach(record.name, record.data)

    def _message(self, message: Message) -> None:
        topic, schema = self._channels[message.channel_id]
        if topic not in TOPICS or schema not in (schema_name(topic), OLD_EVENTS):
            return
        fields = json.loads(message.data)
        if topic == EVENTS and schema == OLD_EVENTS:
            fields["message"] = fields.pop("text")
        self._sink.add(topic, fields.pop("time_s"), fields)


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
