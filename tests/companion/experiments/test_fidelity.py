"""Twins against recordings: figures, criteria, tables, pages."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from rich.console import Console
from simulated_recording import BOOT_S, fly

from companion.arrays import Vec3s
from companion.errors import InputError
from companion.experiments.fidelity import (
    SegmentFidelity,
    TwinFlight,
    evaluate_all,
    fly_segment,
    pooled,
    segments_of,
)
from companion.experiments.fidelity_report import write_fidelity_report
from companion.experiments.fidelity_tables import (
    RecordingFidelity,
    as_json,
    pooled_line,
    prediction_table,
    twin_table,
)
from companion.recording import Recording, Segment, TrackingSeries, Window
from companion.recording.series import rows
from sitl.vehicle import load_vehicle

BEBOP2 = load_vehicle("bebop2")


@pytest.fixture(scope="module")
def recording() -> Recording:
    return fly(BEBOP2, 8.0, segments=("first", "second"))


@pytest.fixture(scope="module")
def own(recording: Recording) -> RecordingFidelity:
    return RecordingFidelity("flight", "bebop2", list(evaluate_all(BEBOP2, recording)))


def test_a_vehicles_own_recording_is_flown_alike(own: RecordingFidelity) -> None:
    assert [flight.segment.id for flight in own.flights] == ["first", "second"]
    settled, moving = own.flights
    assert settled.tracking_rms_m is not None
    assert settled.tracking_rms_m > 0.1
    assert settled.twin_rms_m < 0.01
    assert moving.ratio is not None
    assert moving.ratio < 0.5  # what the integrators held at its start, a state does not tell


def test_another_vehicles_recording_is_not(own: RecordingFidelity, recording: Recording) -> None:
    other = fly_segment(load_vehicle("x500"), recording, recording.segments[0])
    assert other.twin_rms_m > 3.0 * own.flights[0].twin_rms_m


def test_the_online_model_predicts_better_than_constant_velocity(own: RecordingFidelity) -> None:
    for segment in own.segments:
        for prediction in segment.predictions.values():
            assert prediction.gp_rms_m < prediction.constant_velocity_rms_m


def test_the_json_has_its_keys(own: RecordingFidelity) -> None:
    told = json.loads(json.dumps(as_json(own)))
    assert {"name", "segments"} <= set(told)
    for segment in told["segments"]:
        assert {"id", "tracking_rms_m", "twin_rms_m", "ratio", "prediction"} <= set(segment)
        assert set(segment["prediction"]) == {"0.2", "0.36"}
        for prediction in segment["prediction"].values():
            assert set(prediction) == {"gp_rms_m", "constant_velocity_rms_m", "setpoint_rms_m"}
        squares = sum(axis**2 for axis in segment["twin_rms_axes_m"])
        assert segment["twin_rms_m"] == pytest.approx(np.sqrt(squares))


def flight(sent: Vec3s, tracking_error: Vec3s, twin_error: Vec3s) -> TwinFlight:
    recorded = sent - tracking_error
    time_s = np.arange(len(sent), dtype=float)
    return TwinFlight(Segment("one", Window(0.0, 1.0)), time_s, sent, recorded, recorded + twin_error)


def test_rms_distances_are_those_of_hand() -> None:
    sent = np.zeros((2, 3))
    one = flight(sent, np.array(((3.0, 4.0, 0.0), (0.0, 0.0, 0.0))), np.full((2, 3), 1.0))
    assert one.tracking_rms_m == pytest.approx(np.sqrt(12.5))
    assert one.twin_rms_m == pytest.approx(np.sqrt(3.0))
    assert one.ratio == pytest.approx(np.sqrt(3.0 / 12.5))


def test_pooled_wander_is_the_variance_on_axes_that_stay() -> None:
    sent = np.array(((0.0, 0.0, 0.0), (1.0, 0.0, 0.02)))
    errors = np.array(((9.0, 0.5, 0.1), (9.0, 0.7, 0.3)))
    whole = pooled([flight(sent, errors, np.full((2, 3), 0.2))])
    assert whole is not None
    assert whole.wander_m2 == pytest.approx(0.1**2)
    assert whole.twin_m2 == pytest.approx(0.2**2)
    assert whole.tracking_m2 == pytest.approx((errors**2).mean())
    assert whole.allowed_m2 == pytest.approx(1.2 * 0.1**2 + (errors**2).mean() / 16.0)
    assert "within" in pooled_line(whole)
    assert "beyond" in pooled_line(replace(whole, twin_m2=2.0 * (whole.allowed_m2 or 0.0)))


def test_without_an_axis_that_stays_there_is_no_floor() -> None:
    whole = pooled([flight(np.array(((0.0,) * 3, (1.0,) * 3)), np.ones((2, 3)), np.ones((2, 3)))])
    assert whole is not None
    assert whole.allowed_m2 is None
    assert "not known" in pooled_line(whole)


def test_velocities_alone_have_no_tracking_error(recording: Recording) -> None:
    sent = replace(recording.references, position=np.full_like(recording.references.position, np.nan))
    one = fly_segment(BEBOP2, replace(recording, references=sent), recording.segments[0])
    assert one.tracking_rms_m is None
    assert one.ratio is None
    assert one.twin_rms_m >= 0.0
    assert pooled([one]) is None
    told = RecordingFidelity("flight", "bebop2", [SegmentFidelity(one, {})])
    assert as_json(told)["segments"][0]["prediction"] == {}
    assert prediction_table(told).row_count == 1


def test_without_segments_each_stretch_of_setpoints_is_one(recording: Recording) -> None:
    bare = replace(recording, segments=())
    (only,) = segments_of(bare)
    assert only.window.end_s - only.window.start_s > 7.5
    times = recording.references.time_s - BOOT_S
    torn = rows(recording.references, np.flatnonzero((times < 3.0) | (times > 5.0)))
    assert [segment.id for segment in segments_of(replace(bare, references=torn))] == ["flight-1", "flight-2"]


def test_a_vehicle_on_its_way_does_not_follow_yet(recording: Recording) -> None:
    late = replace(recording.states, position=recording.states.position.copy())
    late.position[:300, 2] += 5.0
    (only,) = segments_of(replace(recording, segments=(), states=late))
    assert only.window.start_s == pytest.approx(BOOT_S + 3.0, abs=0.05)


def test_a_tracked_trajectory_is_the_segment(recording: Recording) -> None:
    tracked = np.full((2, 3), 0.0)
    tracking = TrackingSeries(np.array((BOOT_S + 2.0, BOOT_S + 6.0)), *([tracked] * 8), *np.ones((2, 2)))
    (only,) = segments_of(replace(recording, segments=(), tracking=tracking))
    assert (only.window.start_s, only.window.end_s) == pytest.approx((BOOT_S + 2.0, BOOT_S + 6.0), abs=0.03)


def test_a_log_without_setpoints_is_told(recording: Recording) -> None:
    silent = replace(recording, segments=(), references=rows(recording.references, np.arange(0)))
    with pytest.raises(InputError, match="SET_POSITION_TARGET_LOCAL_NED"):
        segments_of(silent)


def test_tables_and_page(own: RecordingFidelity, tmp_path: Path) -> None:
    console = Console(width=80, record=True)
    console.print(twin_table(own), prediction_table(own))
    shown = console.export_text()
    assert "second" in shown
    assert "0.36 s" in shown
    page = write_fidelity_report([own], tmp_path / "report", "companion bench fidelity <flight>")
    assert "&lt;flight&gt;" in page.read_text()
    assert {file.name for file in page.parent.glob("*.png")} == {"01-01.png", "01-02.png"}
