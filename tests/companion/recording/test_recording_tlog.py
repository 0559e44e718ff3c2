"""Telemetry logs read as recordings."""

import json
import lzma
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from logged_messages import UNIX_S, attitude, frame, log, position, setpoint, stamped, telemetry

from companion.errors import InputError
from companion.learning.features import Preview
from companion.learning.training_data import training_pairs
from companion.link.dialect import mavlink
from companion.recording import Recording, Window, bounded_file, cut, read_recording

DATA = Path(__file__).parents[2] / "data"
COMPANION = (245, 191)


def recorded(tmp_path: Path, content: bytes, card: object = None, name: str = "flight.tlog") -> Recording:
    (tmp_path / name).write_bytes(content)
    if card is not None:
        (tmp_path / "flight.json").write_text(json.dumps(card))
    return read_recording(tmp_path / name)


def test_states_are_positions_on_the_vehicle_s_clock_with_their_attitude(tmp_path: Path) -> None:
    states = recorded(tmp_path, log(telemetry())).states
    np.testing.assert_allclose(states.time_s, np.arange(100) / 50.0)
    np.testing.assert_allclose(states.position[:, 0], states.time_s, atol=1e-6)
    assert states.velocity[5].tolist() == [1.0, 0.0, 0.0]
    np.testing.assert_allclose(states.attitude[5], [0.125, -0.25, 0.5])
    np.testing.assert_allclose(states.rates[5], [0.01, 0.02, 0.03], atol=1e-8)


def test_the_quaternion_stands_in_where_there_is_no_attitude(tmp_path: Path) -> None:
    half = np.sqrt(0.5)
    lines = []
    for step in range(50):
        turned = mavlink.MAVLink_attitude_quaternion_message(20 * step, half, 0, 0, half, 0.1, 0.2, 0.3)
        lines += [(step / 50.0, frame(turned)), (step / 50.0, frame(position(step / 50.0)))]
    states = recorded(tmp_path, log(lines)).states
    np.testing.assert_allclose(states.attitude[7], [0.0, 0.0, np.pi / 2.0], atol=1e-7)
    np.testing.assert_allclose(states.rates[7], [0.1, 0.2, 0.3], atol=1e-7)


def test_a_setpoint_acts_when_it_arrives_whatever_its_own_time_says(tmp_path: Path) -> None:
    lines = [*telemetry(booted_s=-3.0), (1.004, frame(setpoint(), *COMPANION))]
    references = recorded(tmp_path, log(lines)).references
    np.testing.assert_allclose(references.time_s, [4.0], atol=1e-6)
    assert references.position.tolist() == [[1.0, 2.0, 3.0]]
    assert references.velocity.tolist() == [[4.0, 5.0, 6.0]]
    assert references.acceleration.tolist() == [[7.0, 8.0, 9.0]]
    assert references.yaw.tolist() == [0.5]


def test_what_a_setpoint_masks_was_not_sent(tmp_path: Path) -> None:
    masks = (0b1, 0b110_000, 0b111_000_000, mavlink.POSITION_TARGET_TYPEMASK_YAW_IGNORE, 1 << 9)
    lines = [(0.5 + 0.1 * place, frame(setpoint(mask), *COMPANION)) for place, mask in enumerate(masks)]
    sent = recorded(tmp_path, log([*telemetry(), *lines])).references
    missing = np.isnan(np.column_stack((sent.position, sent.velocity, sent.acceleration, sent.yaw)))
    assert [np.flatnonzero(row).tolist() for row in missing] == [[0], [4, 5], [6, 7, 8], [9], [6, 7, 8]]


def test_setpoints_for_others_and_in_other_frames_are_left_out(tmp_path: Path) -> None:
    body = setpoint(frame_of=mavlink.MAV_FRAME_BODY_NED)
    sent = [setpoint(x=np.nan), setpoint(target=2), body, setpoint(target=0), body]
    lines = [(0.5 + 0.1 * place, frame(message, *COMPANION)) for place, message in enumerate(sent)]
    recording = recorded(tmp_path, log([*telemetry(), *lines]))
    np.testing.assert_allclose(recording.references.time_s, [0.496, 0.796], atol=1e-6)
    assert np.isnan(recording.references.position[0]).tolist() == [True, False, False]
    assert recording.events[0][1] == "left out: 2 setpoints in other frames than LOCAL_NED"


def test_the_card_names_the_vehicle_and_its_times_move_to_the_vehicle_s_clock(tmp_path: Path) -> None:
    segment = {"id": "a-pv", "start_unix_s": UNIX_S + 0.504, "end_unix_s": UNIX_S + 1.004, "rms_m": 0.5}
    beyond = {"id": "late", "start_unix_s": UNIX_S + 1.0, "end_unix_s": UNIX_S + 2.5}
    card = {
        "vehicle": "px4_sih",
        "system_id": 2,
        "segments": [segment | {"setpoints": "position"}, beyond],
        "hover": {"start_unix_s": UNIX_S + 0.104, "end_unix_s": UNIX_S + 0.404},
    }
    lines = [*telemetry(system=2), *telemetry(system=7, booted_s=-50.0)]
    recording = recorded(tmp_path, log(lines), card)
    assert recording.provenance.vehicle == "px4_sih"
    assert recording.provenance.conditions is None
    assert [(one.id, one.setpoints, one.rms_m) for one in recording.segments] == [("a-pv", "position", 0.5)]
    window, hover = recording.segments[0].window, recording.hover
    assert hover is not None
    found = (window.start_s, window.end_s, hover.start_s, hover.end_s)
    np.testing.assert_allclose(found, (0.5, 1.0, 0.1, 0.4), atol=1e-6)
    assert read_recording(tmp_path / "flight.tlog", system_id=7).states.time_s[0] == 50.0


def test_without_a_card_the_file_names_the_vehicle_and_several_have_to_be_told_apart(tmp_path: Path) -> None:
    ground = mavlink.MAVLink_heartbeat_message(6, 8, 0, 0, 4, 3)
    lines = [*telemetry(), (0.1, frame(ground, 255, 190))]
    assert recorded(tmp_path, log(lines)).provenance.vehicle == "flight"
    with pytest.raises(
        InputError, match=r"flight\.tlog: positions of several vehicles, systems 1, 9: name one"
    ):
        recorded(tmp_path, log([*lines, *telemetry(system=9)]))
    with pytest.raises(InputError, match=r"no LOCAL_POSITION_NED of system 3 \(systems with one: 1\)"):
        recorded(tmp_path, log(lines), {"system_id": 3})


def test_another_component_of_the_vehicle_is_not_its_autopilot(tmp_path: Path) -> None:
    camera = telemetry(seconds=1.0, booted_s=-9.0, component=100)
    states = recorded(tmp_path, log([*telemetry(), *camera])).states
    assert states.time_s[-1] == pytest.approx(1.98)


def test_of_a_restarted_vehicle_the_longest_stretch_is_kept(tmp_path: Path) -> None:
    lines = [
        *telemetry(10.0, 1.0),
        *telemetry(12.0, 3.0, booted_s=11.0),
        *((time_s, frame(setpoint(), *COMPANION)) for time_s in (10.5, 13.0)),
    ]
    recording = recorded(tmp_path, log(lines))
    np.testing.assert_allclose(recording.states.time_s[[0, -1]], [1.0, 3.98])
    np.testing.assert_allclose(recording.references.time_s, [1.996], atol=1e-6)
    assert recording.events[0][1] == "left out: what lies before or behind 1 restarts"


def test_events_tell_what_the_vehicle_said_and_did(tmp_path: Path) -> None:
    half = "x" * 50
    said = [
        mavlink.MAVLink_heartbeat_message(2, 12, 0b10011101, 6 << 16, 4, 3),
        mavlink.MAVLink_heartbeat_message(2, 12, 0b10011101, 6 << 16, 4, 3),
        mavlink.MAVLink_heartbeat_message(2, 3, 0b01, 4, 3, 3),
        mavlink.MAVLink_command_ack_message(400, 0),
        mavlink.MAVLink_command_ack_message(65000, 99),
        mavlink.MAVLink_statustext_message(4, half.encode(), 7, 0),
        mavlink.MAVLink_statustext_message(4, b"yz", 7, 1),
        mavlink.MAVLink_statustext_message(4, b"plain"),
        mavlink.MAVLink_statustext_message(4, b"last", 8, 0),
    ]
    lines = [(0.5 + 0.1 * place, frame(message)) for place, message in enumerate(said)]
    foreign = (0.5, frame(mavlink.MAVLink_statustext_message(4, b"ground"), 255, 190))
    events = recorded(tmp_path, log([*telemetry(), *lines, foreign])).events
    assert [text for _, text in events] == [
        "vehicle: armed, mode OFFBOARD",
        "vehicle: disarmed, mode GUIDED",
        "vehicle: COMPONENT_ARM_DISARM: ACCEPTED",
        "vehicle: 65000: 99",
        f"vehicle: {half}yz",
        "vehicle: plain",
        "vehicle: last",
    ]
    np.testing.assert_allclose(
        [time_s for time_s, _ in events], np.array([5, 7, 8, 9, 10, 12, 13]) / 10 - 0.004, atol=1e-6
    )


@given(st.lists(st.binary(max_size=30) | st.sampled_from([b"\xfd\xff", b"\xfe\x09" * 4]), max_size=6))
def test_no_frame_is_lost_to_garbage_before_it(
    tmp_path_factory: pytest.TempPathFactory, garbage: list[bytes]
) -> None:
    path = tmp_path_factory.getbasetemp() / "garbled.tlog"
    parts = [stamped(time_s, content) for time_s, content in telemetry(seconds=0.2)]
    for place, stray in enumerate(garbage):
        parts.insert(3 * place, stray)
    path.write_bytes(b"".join(parts) + bytes(300))
    assert len(read_recording(path).states.time_s) == 10


def test_signed_frames_and_those_of_version_1_and_a_cut_last_one_are_read(tmp_path: Path) -> None:
    messages = [message(step / 50.0) for step in range(20) for message in (attitude, position)]
    content = b"".join(
        stamped(place / 100.0, frame(message, signed=place % 2 == 0, v1=place % 2 == 1))
        for place, message in enumerate(messages)
    )
    assert len(recorded(tmp_path, content[:-3]).states.time_s) == 19


@pytest.mark.parametrize("content", [b"", b"\x00" * 50, b"t,n,e,d\n" * 50, bytes(range(256)) * 4])
def test_what_is_no_telemetry_log_is_refused(tmp_path: Path, content: bytes) -> None:
    with pytest.raises(InputError, match=r"flight\.tlog: no telemetry log"):
        recorded(tmp_path, content)


def test_a_log_without_positions_or_attitude_is_refused(tmp_path: Path) -> None:
    for message, fault in (
        (attitude, "no LOCAL_POSITION_NED"),
        (position, "no local position with an attitude"),
    ):
        lines = [(step / 50.0, frame(message(step / 50.0))) for step in range(9)]
        with pytest.raises(InputError, match=rf"flight\.tlog: {fault}"):
            recorded(tmp_path, log(lines))


def test_a_packed_log_is_read_as_far_as_it_goes(tmp_path: Path) -> None:
    packed = lzma.compress(log(telemetry()))
    assert len(recorded(tmp_path, packed, name="flight.tlog.xz").states.time_s) == 100
    assert len(recorded(tmp_path, packed[:-200], name="flight.tlog.xz").states.time_s) > 10
    with pytest.raises(InputError, match=r"flight\.tlog\.xz: damaged, or not packed with xz"):
        recorded(tmp_path, log(telemetry()), name="flight.tlog.xz")


def test_a_log_that_unpacks_too_large_is_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(bounded_file, "MAX_BYTES", 2**24)
    with pytest.raises(InputError, match=r"flight\.tlog\.xz: larger than"):
        recorded(tmp_path, lzma.compress(bytes(2**25)), name="flight.tlog.xz")
    monkeypatch.setattr(bounded_file, "MAX_BYTES", 100)
    with pytest.raises(InputError, match=r"flight\.tlog: larger than"):
        recorded(tmp_path, log(telemetry()))


@pytest.mark.parametrize(
    ("name", "vehicle"), [("px4_sih_excerpt", "px4_sih"), ("arducopter_sitl_excerpt", "arducopter_sitl")]
)
def test_a_real_flight_is_read_as_its_card_has_it(name: str, vehicle: str) -> None:
    recording = read_recording(DATA / f"{name}.tlog.xz")
    assert recording.provenance.vehicle == vehicle
    assert recording.hover is not None
    assert recording.hover.end_s - recording.hover.start_s == pytest.approx(15.8, abs=0.5)
    flown = [segment.id for segment in recording.segments]
    assert flown == ["sinusoids-20s-pv", "lasa-CShape-pv", "lasa-CShape-pva"]
    for segment in recording.segments:
        assert segment.rms_m == pytest.approx(tracking_rms(recording, segment.window), rel=0.06)


def tracking_rms(recording: Recording, window: Window) -> float:
    """RMS distance of setpoint and position at setpoint times (m)."""
    sent, states = cut(recording, window.start_s, window.end_s).references, recording.states
    flown = np.column_stack([np.interp(sent.time_s, states.time_s, axis) for axis in states.position.T])
    return float(np.sqrt(np.mean(np.sum((sent.position - flown) ** 2, axis=1))))


def test_a_real_flight_trains() -> None:
    recording = read_recording(DATA / "px4_sih_excerpt.tlog.xz")
    inputs, outputs = training_pairs(recording, Preview.of_time(0.1), 0.02)
    assert len(inputs) == len(outputs) > 2500
