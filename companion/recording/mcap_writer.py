"""Messages as MCAP, which Foxglove and PlotJuggler open as it is: JSON with a JSON schema for each topic.

`log_time` and `publish_time` are the date of a message's `time_s` in whole nanoseconds. Chunks are complete
in themselves, so a file that was cut is read up to its last whole chunk. Format: https://mcap.dev/spec
"""

import json
from typing import Protocol

from mcap.writer import Writer

from companion.recording.series import Provenance
from companion.recording.topics import PROVENANCE, Fields, json_schema, schema_name

_CHUNK_BYTES = 64 * 1024
"""Half a second to a second of a flight, before it is packed."""


class Output(Protocol):
    """What a `McapWriter` needs of a file."""

    def write(self, data: bytes, /) -> int:
        """Append `data`."""
        ...

    def tell(self) -> int:
        """How many bytes were written."""
        ...

    def flush(self) -> None:
        """Hand them on."""
        ...


class McapWriter:
    """Writes messages to `output`, one after another, as one MCAP file.

    Args:
        output: an empty file.
        provenance: what the recording is of.
        epoch_s: Unix time (s) at the zero of the recording's clock; 0 where nobody knows it.
    """

    def __init__(self, output: Output, provenance: Provenance, epoch_s: float = 0.0) -> None:
        self._epoch_s = epoch_s
        self._channels: dict[str, int] = {}
        self._writer = Writer(output, _CHUNK_BYTES, enable_data_crcs=True)  # type: ignore[arg-type]
        self._writer.start(library=f"impromptu {provenance.software}".rstrip())
        self.add_metadata(PROVENANCE, provenance.model_dump(mode="json"))

    def unix_ns(self, time_s: float) -> int:
        """The date of `time_s` on the recording's clock (ns since 1970)."""
        return round((self._epoch_s + time_s) * 1e9)

    def add(self, topic: str, time_s: float, fields: Fields) -> None:
        """Add a message (`companion.recording.topics`); `time_s` is finite, its date not before 1970."""
        channel = self._channels.get(topic) or self._register(topic)
        date_ns = self.unix_ns(time_s)
        body = json.dumps({"time_s": float(time_s), **fields}).encode()
        self._writer.add_message(channel, date_ns, body, date_ns)

    def add_metadata(self, name: str, values: dict[str, object]) -> None:
        """Add what is known once; `values` must be what JSON can say."""
        self._writer.add_metadata(name, {key: json.dumps(value) for key, value in values.items()})

    def attach(self, name: str, data: bytes) -> None:
        """Add bytes that no viewer needs, under a name."""
        self._writer.add_attachment(0, 0, name, "application/octet-stream", data)

    def end_chunk(self) -> None:
        """Hand on all messages so far: what is lost in a crash comes later."""
        self._writer.flush()  # type: ignore[no-untyped-call]

    def finish(self) -> None:
        """End the file with the index that lets viewers jump."""
        self._writer.finish()  # type: ignore[no-untyped-call]

    def _register(self, topic: str) -> int:
        schema = json.dumps(json_schema(topic)).encode()
        schema_id = self._writer.register_schema(schema_name(topic), "jsonschema", schema)
        self._channels[topic] = self._writer.register_channel(topic, "json", schema_id)
        return self._channels[topic]
