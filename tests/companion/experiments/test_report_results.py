"""The table of RMS errors: reductions worked out by hand, gaps, and names taken as they are."""

import io

import pytest
from rich.console import Console

from companion.experiments.results import (
    RmsErrors,
    cell,
    mean_cell,
    results_rows,
    results_table,
    strategies_of,
    trajectories_of,
)

RMS: RmsErrors = {
    ("eight", "baseline"): 0.4,
    ("eight", "gp"): 0.1,
    ("wave [b]", "baseline"): 0.2,
    ("wave [b]", "gp"): 0.1,
    ("wave [b]", "dnn"): 0.3,
}


def test_order_is_that_of_the_flights() -> None:
    assert trajectories_of(RMS) == ["eight", "wave [b]"]
    assert strategies_of(RMS) == ["baseline", "gp", "dnn"]


def test_reduction_is_against_the_baseline_on_the_same_trajectory() -> None:
    gained, lost = cell(RMS, "eight", "gp"), cell(RMS, "wave [b]", "dnn")
    assert gained is not None
    assert lost is not None
    assert gained.reduction == pytest.approx(0.75)
    assert gained.change == "−75 %"
    assert lost.change == "+50 %"


def test_mean_is_taken_of_the_reductions_not_of_the_errors() -> None:
    mean = mean_cell(RMS, "gp")
    assert mean.rms_m == pytest.approx(0.1)
    assert mean.reduction == pytest.approx((0.75 + 0.5) / 2.0)
    assert mean_cell(RMS, "baseline").reduction is None


def test_without_a_baseline_there_is_no_reduction() -> None:
    only = cell({("eight", "gp"): 0.1}, "eight", "gp")
    assert only is not None
    assert only.reduction is None
    assert only.change == ""


def test_rows_leave_gaps_and_end_with_means() -> None:
    rows = results_rows(RMS)
    assert [name for name, _ in rows] == ["eight", "wave [b]", "mean"]
    assert rows[0][1][2] is None
    assert len(results_rows({("eight", "gp"): 0.1})) == 1


def test_terminal_table_fits_and_shows_names_as_they_are() -> None:
    strategies = ("baseline", "feedforward", "lookahead", "dnn", "gp", "dnn+gp")
    console = Console(width=80, file=io.StringIO(), record=True)
    console.print(results_table({("wave [b]", strategy): 0.1 for strategy in strategies}))
    text = console.export_text()
    assert "wave [b]" in text
    assert all(strategy in text for strategy in strategies)
