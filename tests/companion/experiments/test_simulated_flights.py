"""Simulated flights: measured against the truth, failures told, the same on every core."""

import numpy as np
import pytest
from early_network import early_network

from companion.errors import InputError
from companion.experiments import lookahead
from companion.experiments.simulated_flights import (
    Failed,
    Flown,
    Scenario,
    evaluate,
    evaluate_all,
    prepare_simulator,
)
from companion.flight.approach import rest_to_rest
from companion.flight.strategies import Strategy
from companion.learning.online_settings import PAPER
from companion.trajectory.trajectory import Trajectory, quintic_through

START, END = np.array([0.0, 0.0, -2.5]), np.array([0.6, 0.0, -2.5])
SHORT = rest_to_rest(START, END, "short")


def too_fast() -> Trajectory:
    return quintic_through("rocket", 1.0, np.stack([START, START + 20.0]), np.zeros((2, 3)), np.zeros((2, 3)))


def flown(scenario: Scenario) -> Flown:
    result = evaluate(scenario)
    assert isinstance(result, Flown)
    return result


def test_in_ideal_conditions_truth_and_estimate_agree() -> None:
    result = flown(Scenario(SHORT, Strategy.FEEDFORWARD))
    assert result.accuracy.rms_m == pytest.approx(result.estimated_accuracy.rms_m, rel=0.02)
    assert 0.0 < result.accuracy.rms_m < 0.2


def test_the_flight_holds_the_error_that_was_measured() -> None:
    result = flown(Scenario(SHORT, Strategy.BASELINE))
    flight = result.flight
    distance = np.linalg.norm(flight.flown - flight.desired, axis=1)
    assert result.accuracy.max_m == pytest.approx(distance.max())
    assert result.accuracy.rms_m == flight.rms_m == pytest.approx(np.sqrt(np.mean(distance**2)))
    np.testing.assert_allclose(np.diff(flight.time_s), 0.01, atol=1e-9)
    assert flight.time_s[0] < 0.01
    assert SHORT.duration_s - flight.time_s[-1] < 0.01
    np.testing.assert_allclose(flight.desired[-1] - flight.desired[0], END - START, atol=1e-3)


def test_in_realistic_conditions_the_truth_is_not_the_estimate() -> None:
    result = flown(Scenario(SHORT, Strategy.BASELINE, conditions="realistic"))
    assert abs(result.accuracy.rms_m - result.estimated_accuracy.rms_m) > 1e-5


def test_conditions_may_have_errors_measured_against_the_estimate() -> None:
    result = flown(Scenario(SHORT, Strategy.BASELINE, conditions="px4"))
    assert result.accuracy.rms_m == pytest.approx(result.estimated_accuracy.rms_m, rel=1e-12)
    assert result.flight.rms_m == result.accuracy.rms_m


def test_a_flight_that_fails_tells_why_and_the_others_go_on() -> None:
    scenarios = [
        Scenario(too_fast(), Strategy.BASELINE),
        Scenario(SHORT, Strategy.DNN_GP, conditions="realistic", network=early_network()),
    ]
    failed, fine = evaluate_all(scenarios)
    assert isinstance(failed, Failed)
    assert "m from where it should be" in failed.reason
    assert failed.scenario.trajectory.name == "rocket"
    assert isinstance(fine, Flown)
    assert fine.scenario.strategy is Strategy.DNN_GP
    alone = flown(scenarios[1])
    np.testing.assert_array_equal(fine.flight.flown, alone.flight.flown)


def test_learned_strategies_keep_to_their_sample_time_and_plain_ones_to_50_hz() -> None:
    network = early_network()
    periods_s = {
        strategy: Scenario(SHORT, strategy, network=network, lookahead_s=0.1, online=PAPER).plan().period_s
        for strategy in Strategy
    }
    for strategy in (Strategy.DNN, Strategy.GP, Strategy.DNN_GP):
        assert periods_s[strategy] == PAPER.sample_time_s
    for strategy in (Strategy.BASELINE, Strategy.FEEDFORWARD, Strategy.LOOKAHEAD):
        assert periods_s[strategy] == 0.02


@pytest.mark.parametrize(("vehicle", "conditions"), [("zeppelin", "ideal"), ("bebop2", "stormy")])
def test_unknown_vehicles_and_conditions_are_refused(vehicle: str, conditions: str) -> None:
    with pytest.raises(InputError, match=r"zeppelin|stormy"):
        prepare_simulator(["bebop2", vehicle], conditions)


def test_the_slower_vehicle_needs_the_longer_lookahead(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(lookahead, "FLIGHT_S", 20.0)
    slow, quick = (lookahead.measured_lookahead_s(vehicle, "ideal", 0) for vehicle in ("ardrone2", "bebop2"))
    assert 0.05 < quick < slow < 1.0
