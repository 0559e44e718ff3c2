"""What a control step costs, of a flight that is as short as it may be."""

import json
from pathlib import Path

import numpy as np
import pytest
from early_network import early_network
from typer.testing import CliRunner

from companion.cli.app import app
from companion.errors import FlightError
from companion.experiments.simulated_flights import Scenario
from companion.experiments.step_cost import step_cost
from companion.flight.approach import rest_to_rest
from companion.flight.strategies import Strategy
from companion.learning.online_settings import DEFAULT

SHORT = rest_to_rest(np.array([0.0, 0.0, -2.5]), np.array([0.6, 0.0, -2.5]), "short")
QUICK = DEFAULT.model_copy(update={"window": 20})


def test_steps_count_from_when_the_window_is_full() -> None:
    cost = step_cost(Scenario(SHORT, Strategy.DNN_GP, network=early_network(), online=QUICK))
    steps = round(SHORT.duration_s / QUICK.sample_time_s)
    assert abs(steps - (20 + 8) - cost.steps) <= 1  # the window, and until its first outcome is known
    for spread in (cost.elapsed_ms, cost.processor_ms):
        assert 0.0 <= spread.p50 <= spread.p99 <= spread.max
    assert cost.processor_ms.max > 0.0


def test_a_flight_that_never_fills_the_window_measures_nothing() -> None:
    with pytest.raises(FlightError, match="fly longer"):
        step_cost(Scenario(SHORT, Strategy.GP))


def test_the_command_writes_its_figures(tmp_path: Path) -> None:
    file = tmp_path / "step.json"
    result = CliRunner().invoke(
        app,
        ["bench", "step", "--preset", "paper", "--strategy", "gp", "--duration", "10", "--json", str(file)],
    )
    assert result.exit_code == 0, result.output
    told = json.loads(file.read_text())
    assert set(told) == {"steps", "elapsed_ms", "processor_ms", "settings", "software"}
    assert set(told["elapsed_ms"]) == {"p50", "p99", "max"}
    assert told["steps"] > 10
