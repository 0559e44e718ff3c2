"""Two vehicles side by side, and the verdict on them."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_allclose
from spring_flight import answering_the_wrong_way, spring_flight

from companion.errors import InputError
from companion.experiments.linear.experiment import TARGET
from companion.similarity.comparison import compare
from companion.similarity.identification import VehicleModel, identify_recording
from companion.similarity.identified_lemma import scaled
from companion.similarity.linear_system import LinearSystem
from companion.similarity.report import as_json, figures_table, remarks
from companion.similarity.track_record import Pair, network_helped, read_flown_pairs, track_record
from companion.similarity.verdict import Verdict, verdict


@pytest.fixture(scope="module")
def spring() -> VehicleModel:
    return identify_recording(spring_flight(noise=0.003), resamples=20)


@pytest.fixture(scope="module")
def stiff() -> VehicleModel:
    return identify_recording(
        spring_flight(stiffness=40.0, damping=9.0, lag_s=0.05, delay_s=0.0, noise=0.003, seed=1), resamples=20
    )


def test_a_vehicle_is_like_itself(spring: VehicleModel) -> None:
    for axis in compare(spring, spring):
        f = axis.figures
        assert abs(f.s.S1) < 1e-9
        assert f.s.S2_norm < 1e-9
        assert f.nu_gap < 1e-6
        assert f.inverse_error < 1e-6
        assert f.a2_holds
        assert all(band is None or abs(band.theta_1 - 1.0) < 1e-9 for band in axis.envelope)
        assert all(band is None or band.theta_2_m < 1e-6 for band in axis.envelope)
    assert verdict(compare(spring, spring)).verdict is Verdict.TRANSFER


def test_another_flight_of_the_same_vehicle_is_within_the_intervals(spring: VehicleModel) -> None:
    again = identify_recording(spring_flight(noise=0.003, seed=5), resamples=20)
    axes = compare(spring, again)
    judgement = verdict(axes)
    assert judgement.verdict is Verdict.TRANSFER
    assert judgement.confidence > 0.9
    for axis in axes:
        interval = axis.interval(lambda f: f.s.S1)
        assert interval.low - 0.1 < 0.0 < interval.high + 0.1


def test_a_much_stiffer_vehicle_is_told_from_it(spring: VehicleModel, stiff: VehicleModel) -> None:
    axes = compare(spring, stiff)
    assert axes[0].figures.s.S1 < -1.0
    assert axes[0].figures.nu_gap > 0.4
    assert verdict(axes).verdict is not Verdict.TRANSFER
    there, back = axes[0].figures.nu_gap, compare(stiff, spring)[0].figures.nu_gap
    assert there == pytest.approx(back, abs=1e-6)


def test_an_inverse_that_is_not_minimum_phase_is_refused(spring: VehicleModel) -> None:
    north, east, down = (replace(axis, resamples=()) for axis in spring.axes)
    wrong_way = replace(north, model=answering_the_wrong_way(north.model))
    judgement = verdict(compare(replace(spring, axes=(wrong_way, east, down)), spring))
    assert judgement.verdict is Verdict.TRAIN_ANEW
    assert any("minimum phase" in reason for reason in judgement.reasons)
    assert np.isnan(judgement.confidence)


def test_scaling_leaves_the_transfer_function() -> None:
    system = LinearSystem(np.diag([0.5, 0.2, -0.3]), np.array([1.0, 2.0, 0.5]), np.array([1.0, 0.3, -1.0]))
    other = scaled(system, np.array([2.0, 0.1, 7.0]))
    assert_allclose(other.numerator, system.numerator, atol=1e-12)
    assert_allclose(other.denominator, system.denominator, atol=1e-12)
    assert TARGET.relative_degree == 1


def test_report_says_where_the_lemma_is_vacuous(spring: VehicleModel, stiff: VehicleModel) -> None:
    axes = compare(spring, stiff)
    judgement = verdict(axes)
    said = remarks(axes, judgement)
    assert any("Lemma 1 is vacuous" in each for each in said)
    assert said[-1].startswith(f"verdict: {judgement.verdict}")
    assert figures_table(axes).row_count > 20
    told = as_json(axes, judgement)
    assert set(told["axes"]) == {"north", "east", "down"}
    assert set(told["axes"]["north"]["figures"]["s1"]) == {"value", "low", "high"}


def flight(source: str | None, strategy: str, rms_m: float | None) -> dict[str, object]:
    return {
        "source": source,
        "target": "b",
        "trajectory": "star",
        "conditions": "ideal",
        "strategy": strategy,
        "rms_m": rms_m,
        "active_share": 0.5,
    }


def test_track_record_counts_what_the_flights_showed(tmp_path: Path) -> None:
    rows = [
        flight(None, "gp", 0.05),
        flight(None, "baseline", 0.3),
        flight("a", "dnn+gp", 0.04),
        flight("c", "dnn+gp", 0.09),
        flight("d", "dnn+gp", None),
    ]
    file = tmp_path / "pairs.json"
    file.write_text(json.dumps({"rows": rows, "summary": {}}))
    helped = network_helped(read_flown_pairs(file).rows)
    a, c, d = (Pair(source, "b", "ideal") for source in "acd")
    assert helped == {a: True, c: False, d: False}
    said = {a: Verdict.SMALL_GAIN, c: Verdict.TRANSFER, d: Verdict.TRAIN_ANEW}
    record = track_record(said, helped)
    assert (record.right, record.pairs, record.wrong) == (2, 3, (c,))


@pytest.mark.parametrize("text", ["", "{}", '{"rows": [{"source": "a"}]}'])
def test_other_files_are_refused(tmp_path: Path, text: str) -> None:
    file = tmp_path / "other.json"
    file.write_text(text)
    with pytest.raises(InputError, match=r"other\.json"):
        read_flown_pairs(file)
