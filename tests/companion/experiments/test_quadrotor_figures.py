"""The figures of the paper's flights, from results that are made up."""

from typing import Any

import numpy as np
import pytest
from early_network import early_network

from companion.errors import FlightError, InputError
from companion.experiments.comparison import Results, flights, means, rms_errors
from companion.experiments.contenders import (
    SOURCE_BASELINE,
    SOURCE_OWN,
    TARGET_OWN,
    Model,
    find_model,
    library_for,
    own_model_name,
    transferred,
    with_own_networks,
)
from companion.experiments.flights import Flight
from companion.experiments.quadrotor import SUMMARY_KEYS, rows_and_summary, summary_table
from companion.experiments.results import strategies_of, trajectories_of
from companion.experiments.simulated_flights import Failed, Flown, Result, Scenario
from companion.experiments.trajectories import Course
from companion.flight.approach import rest_at, rest_to_rest
from companion.flight.guard import Clip
from companion.flight.strategies import Strategy
from companion.learning.online_settings import DEFAULT, PAPER
from companion.recording.metrics import TrackingAccuracy

MODEL = Model("ardrone2", early_network())
CONTENDERS = transferred("bebop2", list(Strategy), MODEL, 0.2) | with_own_networks(
    "ardrone2", MODEL, "bebop2", Model("bebop2", early_network())
)
RMS_M = {
    "baseline": 0.4,
    "feedforward": 0.2,
    "lookahead": 0.3,
    "dnn": 0.1,
    "gp": 0.05,
    "dnn+gp": 0.02,
    SOURCE_BASELINE: 1.0,
    SOURCE_OWN: 0.25,
    TARGET_OWN: 0.08,
}


def result(trajectory: str, contender: str, rms_m: float) -> Result:
    accuracy = TrackingAccuracy(rms_m, np.array([rms_m, 0.0, 0.0]), 2.0 * rms_m)
    points = np.zeros((3, 3))
    strategy = CONTENDERS[contender].strategy
    return Flown(
        Scenario(rest_at(np.zeros(3), trajectory), strategy),
        accuracy,
        TrackingAccuracy(rms_m + 0.01, np.zeros(3), rms_m),
        Flight(trajectory, strategy, np.arange(3.0), points, points, rms_m),
        {Clip.DISTANCE: 3} if contender == "dnn" else {},
        active_share=0.75 if contender == "dnn" else 0.0,
    )


COURSES = [
    Course(drawing, "xz", speed_m_s, rest_to_rest(np.zeros(3), np.ones(3), drawing))
    for drawing, speed_m_s in (("A", None), ("B", 2.0))
]


def figures_of(results: Results) -> dict[str, Any]:
    return rows_and_summary(COURSES, CONTENDERS, results)


def results(scale: dict[str, float]) -> dict[tuple[str, str], Result]:
    """Two trajectories; on the second every error is larger by its scale."""
    first = {("A", name): result("A", name, rms_m) for name, rms_m in RMS_M.items()}
    second = {("B", name): result("B", name, rms_m * scale.get(name, 1.0)) for name, rms_m in RMS_M.items()}
    return first | second


def failed(whole: Results, *names: tuple[str, str]) -> Results:
    return {
        name: Failed(each.scenario, "it hit a tree") if name in names else each
        for name, each in whole.items()
    }


def test_keys() -> None:
    figures = figures_of(results({}))
    assert set(figures) == {"rows", "summary", "by_speed"}
    assert list(figures["summary"]) == [
        "baseline_rms_m",
        "feedforward",
        "lookahead",
        "dnn",
        "gp",
        "dnn+gp",
        "target_own_dnn",
        "source_own_dnn",
    ]
    assert set(figures["summary"]["dnn+gp"]) == {"rms_m", "reduction"}
    assert len(figures["rows"]) == 2 * len(CONTENDERS)
    assert figures["rows"][3] == {
        "vehicle": "bebop2",
        "strategy": "dnn",
        "model": "ardrone2",
        "conditions": "ideal",
        "trajectory": "A",
        "plane": "xz",
        "speed_m_s": None,
        "reached_m_s": COURSES[0].reached_m_s,
        "rms_m": 0.1,
        "rms_estimate_m": 0.11,
        "rms_axes_m": [0.1, 0.0, 0.0],
        "max_m": 0.2,
        "active_share": 0.75,
        "gp_rms_m": 0.05,
        "event_s": None,
        "recovery_s": None,
        "guard": {"setpoint kept near the vehicle": 3},
        "error": None,
    }


def test_reduction_is_the_mean_over_trajectories_against_the_own_vehicles_baseline() -> None:
    summary = figures_of(results({"baseline": 2.0}))["summary"]
    assert summary["baseline_rms_m"] == pytest.approx(0.6)
    assert summary["dnn"] == pytest.approx({"rms_m": 0.1, "reduction": (0.75 + 0.875) / 2})
    assert summary["target_own_dnn"] == pytest.approx({"rms_m": 0.08, "reduction": (0.8 + 0.9) / 2})
    assert summary["source_own_dnn"] == pytest.approx({"rms_m": 0.25, "reduction": 0.75})


def test_a_failed_flight_is_a_row_with_its_reason_and_leaves_the_means() -> None:
    figures = figures_of(failed(results({"gp": 4.0}), ("A", "gp"), ("A", "dnn"), ("B", "dnn")))
    assert figures["rows"][4] == {
        "vehicle": "bebop2",
        "strategy": "gp",
        "model": None,
        "conditions": "ideal",
        "trajectory": "A",
        "plane": "xz",
        "speed_m_s": None,
        "reached_m_s": COURSES[0].reached_m_s,
        "rms_m": None,
        "rms_estimate_m": None,
        "rms_axes_m": None,
        "max_m": None,
        "active_share": None,
        "gp_rms_m": None,
        "event_s": None,
        "recovery_s": None,
        "guard": {},
        "error": "it hit a tree",
    }
    assert figures["summary"]["gp"] == pytest.approx({"rms_m": 0.2, "reduction": 0.5})
    assert figures["summary"]["dnn"] is None


def test_each_speed_has_a_summary_of_its_own() -> None:
    slow, fast = figures_of(results({"gp": 4.0}))["by_speed"]
    assert (slow["speed_m_s"], fast["speed_m_s"]) == (None, 2.0)
    assert slow["summary"]["gp"]["rms_m"] == pytest.approx(0.05)
    assert fast["summary"]["gp"]["rms_m"] == pytest.approx(0.2)


def test_gp_flies_beside_the_network_that_rests_on_it() -> None:
    assert list(transferred("bebop2", [Strategy.DNN_GP], MODEL, None)) == ["baseline", "dnn+gp", "gp"]


def test_without_any_baseline_there_is_nothing_to_tell() -> None:
    with pytest.raises(FlightError, match="it hit a tree"):
        figures_of(failed(results({}), ("A", "baseline"), ("B", "baseline")))


def test_pictures_tell_a_vehicles_own_network_from_the_transferred_one() -> None:
    names = [(flight.strategy, flight.trajectory_name) for flight in flights(results({}))]
    assert names == [(contender, trajectory) for contender in RMS_M for trajectory in "AB"]


def test_a_first_flight_that_fails_moves_no_column() -> None:
    rms_m = rms_errors(failed(results({}), ("A", "dnn")))
    assert strategies_of(rms_m) == list(RMS_M)
    assert trajectories_of(rms_m) == ["A", "B"]


def test_the_table_names_everything_that_the_summary_does() -> None:
    table = summary_table(means(CONTENDERS, results({})))
    assert tuple(table.columns[0].cells) == SUMMARY_KEYS


def test_a_vehicles_model_is_named_after_its_file() -> None:
    assert own_model_name("bebop2", DEFAULT) == "bebop2"
    assert own_model_name("./mine.yaml", DEFAULT) == "mine"
    assert own_model_name("bebop2", PAPER) == "bebop2_paper"


def test_only_the_target_with_a_network_of_its_own_flies_with_it() -> None:
    assert TARGET_OWN not in with_own_networks("ardrone2", MODEL, "bebop2", None)


def test_a_library_for_a_vehicle_is_without_its_own_network() -> None:
    names = library_for("bebop2", DEFAULT).network.networks
    assert {"ardrone2", "iris"} <= set(names)
    assert "bebop2" not in names
    with pytest.raises(InputError, match="name one"):
        library_for("bebop2", PAPER)


def test_a_model_that_is_not_there_is_refused() -> None:
    with pytest.raises(InputError, match="ornithopter"):
        find_model("ornithopter", DEFAULT)
