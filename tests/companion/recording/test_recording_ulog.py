"""PX4's own logs read as recordings."""

import contextlib
import json
import struct
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TypeAlias

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from companion.errors import InputError
from companion.recording import Recording, read_recording

Rows: TypeAlias = Sequence[Sequence[float]]
"""Of each row the time (s), then the fields."""
Topics: TypeAlias = Mapping[str, Rows]

FIELDS = {
    "vehicle_local_position": "float x;float y;float z;float vx;float vy;float vz;",
    "vehicle_attitude": "float[4] q;",
    "vehicle_angular_velocity": "float[3] xyz;",
    "trajectory_setpoint": "float[3] position;float[3] velocity;float[3] acceleration;float yaw;",
    "vehicle_status": "float nav_state;",
}
SECOND = [step / 50.0 for step in range(50)]
FLIGHT: Topics = {
    "vehicle_local_position": [(t, t, 0.0, -8.0, 1.0, 0.0, 0.0) for t in SECOND],
    "vehicle_attitude": [(t, np.cos(t), 0.0, 0.0, np.sin(t)) for t in SECOND],
    "vehicle_angular_velocity": [(t, 0.1, 0.2, 0.3) for t in SECOND],
    "trajectory_setpoint": [(t, t, 2.0, 3.0, 4.0, 5.0, 6.0, *[np.nan] * 3, 0.5) for t in SECOND],
    "vehicle_status": [(0.0, 4), (0.5, 14), (0.9, 4)],
}


def message(kind: bytes, body: bytes) -> bytes:
    return struct.pack("<Hc", len(body), kind) + body


def ulog(topics: Topics, fields: Mapping[str, str] = FIELDS) -> bytes:
    """https://docs.px4.io/main/en/dev_log/ulog_file_format.html"""
    parts = [b"ULog\x01\x12\x35\x01" + struct.pack("<Q", 0), message(b"B", bytes(40))]
    parts += [message(b"F", f"{topic}:uint64_t timestamp;{fields[topic]}".encode()) for topic in topics]
    parts += [
        message(b"A", struct.pack("<BH", 0, place) + topic.encode()) for place, topic in enumerate(topics)
    ]
    for place, rows in enumerate(topics.values()):
        for time_s, *values in rows:
            row = struct.pack(f"<HQ{len(values)}f", place, round(time_s * 1e6), *values)
            parts.append(message(b"D", row))
    parts.append(message(b"L", struct.pack("<BQ", ord("6"), 250_000) + b"Armed by external command"))
    return b"".join(parts)


def recorded(tmp_path: Path, content: bytes) -> Recording:
    (tmp_path / "flight.ulg").write_bytes(content)
    return read_recording(tmp_path / "flight.ulg")


def test_states_come_from_the_estimator_and_the_gyroscope(tmp_path: Path) -> None:
    states = recorded(tmp_path, ulog(FLIGHT)).states
    np.testing.assert_allclose(states.time_s, SECOND)
    np.testing.assert_allclose(states.position[:, 0], SECOND, atol=1e-6)
    np.testing.assert_allclose(states.velocity[0], [1.0, 0.0, 0.0])
    np.testing.assert_allclose(states.attitude[:, 2], 2.0 * np.array(SECOND), atol=1e-6)
    np.testing.assert_allclose(states.rates[7], [0.1, 0.2, 0.3], atol=1e-7)


def test_references_are_those_of_offboard_flight(tmp_path: Path) -> None:
    references = recorded(tmp_path, ulog(FLIGHT)).references
    np.testing.assert_allclose(references.time_s[[0, -1]], [0.5, 0.88])
    np.testing.assert_allclose(references.position[0], [0.5, 2.0, 3.0])
    np.testing.assert_allclose(references.velocity[0], [4.0, 5.0, 6.0])
    assert np.isnan(references.acceleration).all()
    assert (references.yaw == 0.5).all()


def test_a_log_may_lack_the_status_and_the_gyroscope(tmp_path: Path) -> None:
    kept = {topic: FLIGHT[topic] for topic in [*list(FIELDS)[:2], "trajectory_setpoint"]}
    recording = recorded(tmp_path, ulog(kept))
    assert len(recording.references.time_s) == 50
    np.testing.assert_allclose(recording.states.rates, np.tile([0.0, 0.0, 2.0], (50, 1)), atol=1e-4)


def test_the_card_names_the_vehicle_and_px4_tells_what_happened(tmp_path: Path) -> None:
    assert recorded(tmp_path, ulog(FLIGHT)).provenance.vehicle == "flight"
    (tmp_path / "flight.json").write_text(json.dumps({"vehicle": "x500"}))
    recording = recorded(tmp_path, ulog(FLIGHT))
    assert recording.provenance.vehicle == "x500"
    assert recording.events == ((0.25, "vehicle: Armed by external command"),)


@pytest.mark.parametrize("topic", ["vehicle_local_position", "vehicle_attitude", "trajectory_setpoint"])
def test_a_missing_topic_is_named(tmp_path: Path, topic: str) -> None:
    others = {name: rows for name, rows in FLIGHT.items() if name != topic}
    with pytest.raises(InputError, match=rf"flight\.ulg: the log has no topic {topic}: "):
        recorded(tmp_path, ulog(others))


def test_a_field_of_another_version_of_px4_is_named(tmp_path: Path) -> None:
    content = ulog(
        FLIGHT, FIELDS | {"trajectory_setpoint": FIELDS["trajectory_setpoint"].replace("yaw", "psi")}
    )
    with pytest.raises(InputError, match=r"flight\.ulg: topic trajectory_setpoint has no field yaw: "):
        recorded(tmp_path, content)


@pytest.mark.parametrize("content", [b"", b"ULog", b"t,n,e,d\n" * 50])
def test_what_is_no_ulog_is_refused(tmp_path: Path, content: bytes) -> None:
    with pytest.raises(InputError, match=r"flight\.ulg: damaged, or no ULog of PX4"):
        recorded(tmp_path, content)


def test_damage_at_the_end_of_a_cut_log_does_not_go_on_for_ever(tmp_path: Path) -> None:
    header_and_flags = ulog({})[:59]
    with pytest.raises(InputError, match=r"flight\.ulg: the log has no topic"):
        recorded(tmp_path, header_and_flags + b"\xff\xff\x00" + bytes(9))


@given(place=st.integers(0, len(ulog(FLIGHT)) - 1), value=st.integers(0, 255))
def test_a_damaged_log_is_read_or_refused(
    tmp_path_factory: pytest.TempPathFactory, place: int, value: int
) -> None:
    path = tmp_path_factory.getbasetemp() / "damaged.ulg"
    content = bytearray(ulog(FLIGHT))
    content[place] = value
    path.write_bytes(content)
    with contextlib.suppress(InputError):
        assert read_recording(path).states.position.shape[1] == 3
