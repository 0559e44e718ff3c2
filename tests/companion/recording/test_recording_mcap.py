"""A recording written as MCAP: read back to the bit, opened by viewers, and refused when it is not one."""

import contextlib
import json
from dataclasses import fields
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from mcap.reader import make_reader
from mcap.writer import CompressionType, Writer

from companion.arrays import Times, Vec3s
from companion.errors import InputError
from companion.recording import mcap_reader, topics
from companion.recording.mcap_file import read_mcap, write_recording
from companion.recording.mcap_writer import McapWriter
from companion.recording.segments import Segment, Window
from companion.recording.series import (
    Provenance,
    Recording,
    ReferenceSeries,
    StateSeries,
    TrackingSeries,
    digest,
)

PROVENANCE = Provenance(vehicle="bebop2", trajectory="eight", conditions="ideal", seed=3)


def vectors(rows: int, start: float) -> Vec3s:
    return start + np.arange(3.0 * rows).reshape(rows, 3) / 3.0


def recording(rows: int = 300) -> Recording:
    time_s: Times = np.linspace(0.1, 3.1, rows)
    one, two, three, four = (vectors(rows, start) for start in (0.0, 2.0, -4.0, 1e-9))
    nothing = np.full((rows, 3), np.nan)
    yaw = np.where(time_s < 1.0, np.nan, time_s)
    return Recording(
        provenance=PROVENANCE,
        states=StateSeries(time_s, one, two, three, four),
        references=ReferenceSeries(time_s[::2], one[::2], two[::2], nothing[::2], yaw[::2]),
        tracking=TrackingSeries(
            time_s[1::2], *(v[1::2] for v in (one, two, three, one, two, nothing, four, one, yaw, time_s))
        ),
        events=((0.0, "armed"), (1.5, "Übergabe\nat last")),
        segments=(
            Segment("eight-pv", Window(1.0, 1.5), "position+velocity", 0.25),
            Segment("é", Window(2.0, 3.0)),
        ),
        hover=Window(0.2, 0.9),
    )


def assert_same(one: Recording, two: Recording) -> None:
    assert one.provenance == two.provenance
    assert one.events == two.events
    assert (one.segments, one.hover) == (two.segments, two.hover)
    for name in ("states", "references", "tracking"):
        series, other = getattr(one, name), getattr(two, name)
        for column in fields(series):
            np.testing.assert_array_equal(getattr(series, column.name), getattr(other, column.name))


def test_what_is_written_is_read_back_to_the_bit(tmp_path: Path) -> None:
    write_recording(recording(), tmp_path / "flight.mcap")
    assert_same(read_mcap(tmp_path / "flight.mcap"), recording())


@given(numbers=arrays(np.float64, (4, 3), elements=st.floats(allow_infinity=False)))
def test_any_number_survives(numbers: Vec3s, tmp_path_factory: pytest.TempPathFactory) -> None:
    path = tmp_path_factory.getbasetemp() / "any.mcap"
    time_s = np.array([0.0, 0.1, 0.1, 1e5 / 3.0])
    states = StateSeries(time_s, numbers, -numbers, numbers, numbers)
    original = Recording(PROVENANCE, states, ReferenceSeries(time_s, numbers, numbers, numbers, time_s))
    write_recording(original, path)
    again = read_mcap(path)
    assert digest(again) == digest(original)
    np.testing.assert_array_equal(
        np.signbit(again.states.velocity), np.signbit(-numbers) & ~np.isnan(numbers)
    )


def test_empty_series_and_extra_provenance_survive(tmp_path: Path) -> None:
    none = np.empty((0, 3))
    empty = Recording(
        Provenance.model_validate({"vehicle": "x500", "box": {"north_m": 3.0}}),
        StateSeries(np.empty(0), none, none, none, none),
        ReferenceSeries(np.empty(0), none, none, none, np.empty(0)),
    )
    write_recording(empty, tmp_path / "empty.mcap")
    again = read_mcap(tmp_path / "empty.mcap")
    assert again.provenance == empty.provenance
    assert again.states.position.shape == (0, 3)
    assert again.tracking is None


def test_same_recording_same_bytes(tmp_path: Path) -> None:
    write_recording(recording(), tmp_path / "a.mcap")
    write_recording(recording(), tmp_path / "b.mcap")
    assert (tmp_path / "a.mcap").read_bytes() == (tmp_path / "b.mcap").read_bytes()


def test_viewers_find_schemas_index_and_rising_times(tmp_path: Path) -> None:
    write_recording(recording(), tmp_path / "flight.mcap")
    with (tmp_path / "flight.mcap").open("rb") as file:
        reader = make_reader(file, validate_crcs=True)
        summary = reader.get_summary()
        assert summary is not None
        assert {channel.topic for channel in summary.channels.values()} == {
            "/state",
            "/reference",
            "/tracking",
            "/events",
        }
        times = [message.log_time for _, _, message in reader.iter_messages(log_time_order=False)]
        assert times == sorted(times)
        for schema, channel, message in reader.iter_messages():
            assert schema is not None
            assert schema.encoding == "jsonschema"
            assert channel.message_encoding == "json"
            body = json.loads(message.data, parse_constant=pytest.fail)  # NaN is no JSON
            assert message.log_time == round(body["time_s"] * 1e9)
            assert_follows(body, json.loads(schema.data))


def assert_follows(value: object, schema: dict[str, object]) -> None:
    """Viewers know only single types: no unions, no null."""
    kinds: dict[str, type] = {"object": dict, "number": float, "integer": int, "string": str}
    assert isinstance(value, kinds[str(schema["type"])])
    if isinstance(value, dict):
        properties = schema["properties"]
        assert isinstance(properties, dict)
        for key, part in value.items():
            assert_follows(part, properties[key])


def state(x: float) -> topics.Fields:
    place = np.full(3, x)
    return topics.row(topics.STATE, dict.fromkeys(("position", "velocity", "attitude", "rates"), place))


def test_rows_come_back_in_the_order_in_which_they_were_added(tmp_path: Path) -> None:
    with (tmp_path / "live.mcap").open("wb") as file:
        writer = McapWriter(file, PROVENANCE)
        writer.add(topics.STATE, 2.0, state(0.0))
        writer.add(topics.STATE, 1.0, state(1.0))
        writer.add(topics.EVENTS, 0.5, topics.event(0, "late"))
        writer.finish()
    again = read_mcap(tmp_path / "live.mcap")
    assert again.states.time_s.tolist() == [2.0, 1.0]
    assert again.events == ((0.5, "late"),)


def test_events_of_before_they_were_shown_as_a_log_are_read(tmp_path: Path) -> None:
    path = tmp_path / "old.mcap"
    with path.open("wb") as file:
        writer = Writer(file)
        writer.start()
        writer.add_metadata("provenance", {"vehicle": '"bebop2"'})
        schema = writer.register_schema("impromptu.Events", "jsonschema", b"{}")
        channel = writer.register_channel("/events", "json", schema)
        writer.add_message(channel, 0, b'{"time_s": 0.5, "text": "armed"}', 0)
        writer.finish()  # type: ignore[no-untyped-call]
    assert read_mcap(path).events == ((0.5, "armed"),)


def test_references_without_a_yaw_are_read_without_one(tmp_path: Path) -> None:
    path = tmp_path / "old.mcap"
    with path.open("wb") as file:
        writer = McapWriter(file, PROVENANCE)
        sent = dict.fromkeys(("position", "velocity", "acceleration"), np.zeros(3))
        writer.add(topics.REFERENCE, 1.0, topics.row(topics.REFERENCE, sent))
        writer.finish()
    again = read_mcap(path)
    assert np.isnan(again.references.yaw).all()
    assert again.references.yaw.shape == (1,)
    assert (again.segments, again.hover) == ((), None)


def test_a_file_cut_before_its_provenance_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "cut.mcap"
    write_recording(recording(), path)
    for length in (0, 3, 8, 20, 60):
        path.write_bytes(path.read_bytes()[:length])
        with pytest.raises(InputError, match=r"cut\.mcap: no recording"):
            read_mcap(path)


def test_a_damaged_file_is_refused_in_one_line(tmp_path: Path) -> None:
    path = tmp_path / "bad.mcap"
    write_recording(recording(), path)
    data = path.read_bytes()
    in_a_chunk, in_provenance = len(data) // 3, data.index(b"bebop2")
    for place in (in_a_chunk, in_provenance):
        path.write_bytes(data[:place] + bytes([data[place] ^ 0x04]) + data[place + 1 :])
        with pytest.raises(InputError, match=r"bad\.mcap: damaged before byte") as caught:
            read_mcap(path)
        assert "\n" not in str(caught.value)


@given(data=st.data())
def test_mutated_files_are_read_or_refused(
    data: st.DataObject, tmp_path_factory: pytest.TempPathFactory
) -> None:
    path = tmp_path_factory.getbasetemp() / "mutated.mcap"
    write_recording(recording(rows=20), path)
    content = bytearray(path.read_bytes())
    for _ in range(data.draw(st.integers(1, 4))):
        content[data.draw(st.integers(0, len(content) - 1))] = data.draw(st.integers(0, 255))
    path.write_bytes(content)
    with contextlib.suppress(InputError):
        assert read_mcap(path).states.position.shape[1] == 3


def test_other_files_are_refused(tmp_path: Path) -> None:
    text = tmp_path / "text.csv"
    text.write_text("t,n,e,d\n" * 20)
    with pytest.raises(InputError, match=r"text\.csv: damaged before byte 8, or no MCAP file"):
        read_mcap(text)
    other = tmp_path / "other.mcap"
    with other.open("wb") as file:
        writer = Writer(file, compression=CompressionType.NONE)
        writer.start()
        channel = writer.register_channel(
            "/state", "json", writer.register_schema("other.State", "jsonschema", b"{}")
        )
        writer.add_message(channel, 0, b"{}", 0)
        writer.finish()  # type: ignore[no-untyped-call]
    with pytest.raises(InputError, match=r"other\.mcap: no recording of Impromptu"):
        read_mcap(other)
    with pytest.raises(InputError, match=r"absent\.mcap: cannot be read"):
        read_mcap(tmp_path / "absent.mcap")
    with pytest.raises(InputError, match="cannot be written"):
        write_recording(recording(), tmp_path / "no" / "folder.mcap")


def test_a_recording_that_unpacks_too_large_is_refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "large.mcap"
    write_recording(recording(), path)
    monkeypatch.setattr(mcap_reader, "MAX_BYTES", path.stat().st_size + 100)
    with pytest.raises(InputError, match=r"large\.mcap: larger than"):
        read_mcap(path)


def test_digest_tells_recordings_apart() -> None:
    one = recording()
    assert digest(one) == digest(recording())
    assert digest(one) != digest(recording(rows=301))
    assert digest(one) != digest(Recording(one.provenance, one.states, one.references))
