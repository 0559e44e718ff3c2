"""Two vehicles side by side, and the verdict on them."""

import json
import re
from dataclasses import replace
from io import StringIO
from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_allclose
from rich.console import Console
from rich.text import Text
from spring_flight import answering_the_wrong_way, spring_flight

from companion.errors import InputError
from companion.experiments.linear.experiment import TARGET
from companion.similarity.comparison import AxisComparison, Figures, compare
from companion.similarity.identification import AXES, VehicleModel, identify_recording
from companion.similarity.identified_lemma import scaled
from companion.similarity.lemma import StateResponse
from companion.similarity.linear_system import LinearSystem
from companion.similarity.report import as_json, figures_table, remarks
from companion.similarity.track_record import (
    MEASURED,
    Pair,
    network_helped,
    read_flown_pairs,
    track_record,
)
from companion.similarity.transfer_loop import MOST_GAIN
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
        assert all(band is None or abs(band.theta_1 - 1.0) < 1e-9 for band in f.envelope)
        assert all(band is None or band.theta_2_m < 1e-6 for band in f.envelope)
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
    north, east, down = (replace(axis, resampled=()) for axis in spring.axes)
    wrong_way = replace(north, estimate=north.estimate._replace(model=answering_the_wrong_way(north.model)))
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
    said = remarks(axes, judgement, MEASURED)
    assert any("Lemma 1 is vacuous" in each for each in said)
    *_, words, record, advice = said
    assert words.startswith(f"verdict: {judgement.verdict} (in ")
    assert record == MEASURED.in_words()
    assert advice == judgement.verdict.advice
    told = as_json(axes, judgement, MEASURED)
    assert set(told["axes"]) == {"north", "east", "down"}
    assert set(told["axes"]["north"]["figures"]["s1"]) == {"value", "low", "high"}


def printed(axes: tuple[AxisComparison, ...]) -> str:
    """The table on a terminal of 80 columns."""
    console = Console(width=80, file=StringIO())
    with console.capture() as capture:
        console.print(figures_table(axes))
    return capture.get()


def row(table: str, title: str) -> list[str]:
    """The cells of a row, with the intervals that stand below them."""
    lines = table.splitlines()
    (at,) = (k for k, line in enumerate(lines) if line.startswith(title))
    cell = re.compile(r"yes|no bound|\S+ \[–\]|≥ 100|too little flown|\[[^]]*\]|[-.\d∞–]+")
    below = cell.findall(lines[at + 1]) if lines[at + 1].startswith(" ") else []
    return cell.findall(lines[at].removeprefix(title)) + below


def of_axis(axis: AxisComparison, figures: Figures) -> tuple[AxisComparison, ...]:
    """North, east and down with these figures, in the resamples too."""
    return tuple(replace(axis, axis=name, figures=figures, resampled=(figures,) * 5) for name in AXES)


def test_brackets_are_printed_and_what_is_unknown_is_no_nan(spring: VehicleModel) -> None:
    axis = compare(spring, spring)[0]
    f = axis.figures
    unbounded = replace(f, lemma=replace(f.lemma, response=StateResponse(np.inf, np.inf)))
    table = printed(of_axis(axis, replace(unbounded, envelope=(None, None, None))))
    assert row(table, "L1") == ["∞"] * 3 + ["[∞, ∞]"] * 3
    assert row(table, "A2 holds") == ["yes", "[100%]"] * 3
    assert row(table, "θ1, faster") == ["too little flown"] * 3
    cells = [cell for column in figures_table((axis,)).columns[1:] for cell in column.cells]
    assert all(isinstance(cell, Text) for cell in cells)
    unsure = printed((replace(axis, resampled=()),))
    assert row(unsure, "A2 holds") == ["yes"]
    assert row(unsure, "S1") == ["0 [–]"]
    assert "nan" not in table + unsure
    assert "inf" not in table + unsure


def test_bounds_have_no_interval_of_their_own(spring: VehicleModel, stiff: VehicleModel) -> None:
    axes = compare(spring, stiff)
    table, told = printed(axes), as_json(axes, verdict(axes), MEASURED)["axes"]["north"]["figures"]
    for title, key in (("β1", "beta_1"), ("β2", "beta_2"), ("β3", "beta_3")):
        assert all(cell.endswith(" [–]") for cell in row(table, title))
        assert told[key]["value"] > 0.0
        assert np.isnan([told[key]["low"], told[key]["high"]]).all()


def test_the_table_fits_80_columns_without_powers_of_ten(spring: VehicleModel) -> None:
    axis = compare(spring, spring)[0]
    lemma = replace(axis.figures.lemma, inverse_state_gain=54321.0, S2_norm=0.00123456)
    table = printed(of_axis(axis, replace(axis.figures, lemma=lemma)))
    assert "…" not in table
    assert row(table, "‖𝒜s/ℬs‖") == ["54300"] * 3 + ["[54300, 54300]"] * 3
    assert (
        row(printed(of_axis(axis, replace(axis.figures, exact_gain=-4234.5))), "α* = 1/ℬt")[-1]
        == "[-4230, -4230]"
    )


def test_where_the_search_for_a_stable_gain_ended_is_no_figure(spring: VehicleModel) -> None:
    axis = compare(spring, spring)[0]
    table = printed(of_axis(axis, replace(axis.figures, stable_gain=MOST_GAIN)))
    assert row(table, "stable: α under") == ["≥ 100"] * 3 + ["[≥ 100, ≥ 100]"] * 3
    table = printed(of_axis(axis, replace(axis.figures, stable_gain=0.0)))
    assert row(table, "stable: α under") == ["0"] * 3 + ["[0, 0]"] * 3


def test_dead_time_drift_and_envelope_have_intervals(spring: VehicleModel, stiff: VehicleModel) -> None:
    axes = compare(spring, stiff)
    told = as_json(axes, verdict(axes), MEASURED)["axes"]["north"]
    for key in (
        "source_relative_degree",
        "target_relative_degree",
        "source_delay_s",
        "target_delay_s",
        "target_drift_m_s",
        "inverse_state_gain",
    ):
        figure = told["figures"][key]
        assert figure["low"] <= figure["value"] <= figure["high"], key
    assert told["figures"]["target_drift_m_s"]["low"] < told["figures"]["target_drift_m_s"]["high"]
    slowest = told["envelope"]["to 0.4 m/s"]
    for key in ("theta_1", "theta_2_m"):
        assert slowest[key]["low"] < slowest[key]["high"]
    table = printed(axes)
    assert len(row(table, "source: delay (s)")) == len(row(table, "target: drift m/s")) == 6
    assert len(row(table, "θ1, to 0.4 m/s")) == 6


def test_an_axis_at_rest_is_left_out(spring: VehicleModel) -> None:
    north, east, down = spring.axes
    still = replace(east, spread=0.01 * east.spread)
    axes = compare(spring, replace(spring, axes=(north, still, down)))
    assert [axis.axis for axis in axes] == ["north", "down"]
    assert remarks(axes, verdict(axes), MEASURED)[0].startswith("east left out: ")
    with pytest.raises(InputError, match="no axis along which both moved"):
        compare(spring, replace(spring, axes=(still, still, still)))


def test_a_drift_of_some_resamples_lowers_the_confidence(spring: VehicleModel) -> None:
    axes = compare(spring, spring)
    drifting = [
        replace(
            axis, resampled=tuple(replace(f, drift_m_s=0.5 * (k % 2)) for k, f in enumerate(axis.resampled))
        )
        for axis in axes
    ]
    assert verdict(axes).confidence == 1.0
    assert verdict(drifting).confidence == 0.5


def test_without_resamples_no_interval_is_told(spring: VehicleModel) -> None:
    axes = tuple(replace(axis, resampled=()) for axis in compare(spring, spring))
    said = remarks(axes, verdict(axes), MEASURED)
    assert "nan" not in " ".join(said)
    assert "verdict: transfer" in said


@pytest.mark.parametrize(
    ("verdict_", "words"),
    [
        (Verdict.TRANSFER, "dnn+gp"),
        (Verdict.SMALL_GAIN, "not as `dnn`"),
        (Verdict.TRAIN_ANEW, "companion collect"),
    ],
)
def test_each_verdict_says_what_to_do(verdict_: Verdict, words: str) -> None:
    assert words in verdict_.advice


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
    record = track_record("pairs.json", said, helped)
    assert (record.right, record.pairs) == (2, 3)
    assert record.tallies == {
        Verdict.TRANSFER: (0, 1),
        Verdict.SMALL_GAIN: (1, 1),
        Verdict.TRAIN_ANEW: (1, 1),
    }
    assert (record.allowed_though_harmful, record.refused_though_harmless) == (1, 0)
    assert record.right_if_always_transfer == 1
    assert record.as_json()["wrong"] == [
        {"source": "c", "target": "b", "conditions": "ideal", "verdict": "transfer"}
    ]


def test_a_refusal_of_what_was_harmless_is_counted_as_such() -> None:
    refused, allowed = Pair("a", "b", "ideal"), Pair("c", "b", "ideal")
    said = {refused: Verdict.TRAIN_ANEW, allowed: Verdict.TRANSFER}
    record = track_record("pairs.json", said, {refused: True, allowed: True})
    assert (record.right, record.refused_though_harmless, record.allowed_though_harmful) == (1, 1, 0)
    assert record.right_if_always_transfer == 2
    assert record.in_words() == (
        "over the pairs flown (pairs.json), the verdict was right for 1 of 2: transfer 1 of 1, "
        "transfer with small gain 0 of 0, train anew 0 of 1; "
        "1 refused though harmless, 0 allowed though harmful; "
        '"transfer" for all would have been right for 2'
    )


def test_the_record_that_ships_says_which_way_the_verdict_errs() -> None:
    told = MEASURED.as_json()
    assert told["pairs"] == sum(tally["pairs"] for tally in told["by_verdict"].values())
    assert told["pairs"] - told["right"] == told["refused_though_harmless"] + told["allowed_though_harmful"]
    assert told["wrong"] is None


@pytest.mark.parametrize("text", ["", "{}", '{"rows": [{"source": "a"}]}'])
def test_other_files_are_refused(tmp_path: Path, text: str) -> None:
    file = tmp_path / "other.json"
    file.write_text(text)
    with pytest.raises(InputError, match=r"other\.json"):
        read_flown_pairs(file)
