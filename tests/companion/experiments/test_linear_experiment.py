"""The paper's simulation, shortened: the order of its figures, and that it repeats to the last bit."""

import json
import sys
from functools import partial
from pathlib import Path

import numpy as np
import pytest

from companion.cli import bench_linear
from companion.errors import InputError
from companion.experiments.backend import Backend
from companion.experiments.linear import noise
from companion.experiments.linear.experiment import (
    AMPLIFYING_TARGET,
    SOURCE,
    TARGET,
    Outcome,
    desired_outputs,
    evaluate,
    track,
    train_source_network,
)
from companion.experiments.linear.inverse import InverseNetwork
from companion.experiments.linear.online import PAPER_SETTINGS, OnlineSettings
from companion.experiments.linear.system import LinearSystem

STEPS = 1500


@pytest.fixture(scope="module")
def network() -> InverseNetwork:
    return train_source_network(seed=0)


@pytest.fixture(scope="module")
def outcome(network: InverseNetwork) -> Outcome:
    return evaluate(TARGET, network, OnlineSettings(), steps=STEPS)


@pytest.mark.parametrize("target", [TARGET, AMPLIFYING_TARGET])
def test_online_correction_reaches_the_wanted_errors(network: InverseNetwork, target: LinearSystem) -> None:
    figures = evaluate(target, network, OnlineSettings(), steps=STEPS).figures()
    assert figures.dnn_rms < 0.3 * figures.baseline_rms
    # The start makes up all of it, so the full run divides it by the root of 20,000 / 1,500.
    assert figures.dnn_gp_rms * np.sqrt(STEPS / 20_000) < 9e-6
    assert figures.prediction_rms < 2e-7


def test_quadratic_basis_without_probe_reaches_the_papers_figures(network: InverseNetwork) -> None:
    figures = evaluate(TARGET, network, PAPER_SETTINGS, steps=STEPS).figures()
    assert figures.dnn_gp_rms * np.sqrt(STEPS / 20_000) < 9e-6
    assert figures.prediction_rms < 2.9e-7


def test_without_probe_the_linear_basis_tracks_but_mispredicts(network: InverseNetwork) -> None:
    figures = evaluate(TARGET, network, OnlineSettings(probe=0.0), steps=STEPS).figures()
    assert figures.dnn_gp_rms * np.sqrt(STEPS / 20_000) < 9e-6
    assert figures.prediction_rms > 1e-4


def test_trained_network_is_the_inverse_of_the_source(network: InverseNetwork) -> None:
    state, desired = np.array([0.7, -1.1]), 0.9
    reference, slope = network.linearise(state, desired)
    exact_slope = np.append(-SOURCE.state_gain, 1.0) / SOURCE.input_gain
    assert reference == pytest.approx(exact_slope @ [*state, desired], abs=1e-3)
    np.testing.assert_allclose(slope, exact_slope, atol=2e-3)
    assert network(state, desired) == reference


def test_network_on_its_own_source_tracks_closely(network: InverseNetwork) -> None:
    desired = desired_outputs(STEPS + 1)
    own = track(SOURCE, desired, lambda state, _output, y_d: network(state, y_d))
    assert np.max(np.abs(own.outputs - desired[:-1])) < 1e-4


def test_gain_is_estimated(network: InverseNetwork) -> None:
    outcome = evaluate(AMPLIFYING_TARGET, network, OnlineSettings(), steps=300)
    full = slice(outcome.window_full, None)
    np.testing.assert_allclose(outcome.alpha[full], 1.0 / AMPLIFYING_TARGET.input_gain, atol=1e-6)
    assert outcome.alpha[0] == pytest.approx(1.0 / SOURCE.input_gain, abs=1e-3)


def test_window_is_full_on_the_step_after_the_thirtieth_observation(outcome: Outcome) -> None:
    assert outcome.window_full == 30


def test_same_seed_gives_the_same_bits(network: InverseNetwork, outcome: Outcome) -> None:
    again = evaluate(TARGET, network, OnlineSettings(), steps=STEPS)
    assert np.array_equal(outcome.dnn_gp.references, again.dnn_gp.references)
    assert np.array_equal(outcome.predicted_error, again.predicted_error)


def test_noise_reaches_the_strategy_but_not_the_returned_truth() -> None:
    seen = []

    def idle(state: np.ndarray, output: float, _desired: float) -> float:
        seen.append(output - SOURCE.C @ state)
        return 0.0

    result = track(SOURCE, desired_outputs(51), idle, noise=0.1)
    assert np.all(result.outputs == 0.0)
    assert np.std(seen) > 0.05


@pytest.mark.parametrize("target", [TARGET, AMPLIFYING_TARGET])
def test_under_noise_the_correction_is_never_worse_than_the_network_alone(
    network: InverseNetwork, target: LinearSystem, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(noise, "LOCAL", Backend("sequential"))
    rows = list(noise.noise_figures(target, network, OnlineSettings(), seeds=[0, 1], steps=400))
    assert [row.noise for row in rows] == [1e-4, 1e-3, 1e-2]
    for row in rows:
        assert row.not_worse == row.draws == 2
        assert row.worst_ratio <= 1.0
        assert row.dnn_gp_rms < row.dnn_rms < row.baseline_rms


def test_without_draws_there_are_no_figures(network: InverseNetwork) -> None:
    assert not list(noise.noise_figures(TARGET, network, OnlineSettings(), seeds=[]))


def test_command_writes_figures_and_plots(
    network: InverseNetwork, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    pytest.importorskip("matplotlib")
    monkeypatch.setattr(bench_linear, "evaluate", partial(evaluate, steps=100))
    monkeypatch.setattr(noise, "evaluate", lambda *given, steps, **also: evaluate(*given, steps=100, **also))
    monkeypatch.setattr(noise, "LOCAL", Backend("sequential"))
    monkeypatch.setattr(bench_linear, "train_source_network", lambda seed: network)
    bench_linear.linear(
        json=tmp_path / "new" / "linear.json", output=tmp_path / "plots", seed=0, noise_draws=1
    )

    written = json.loads((tmp_path / "new" / "linear.json").read_text())
    keys = {"baseline_rms", "dnn_rms", "dnn_gp_rms", "prediction_rms"}
    assert keys | {"second_pair"} <= written.keys()
    assert written["second_pair"].keys() == keys
    assert [row["draws"] for row in written["noise"]] == [1, 1, 1]
    assert len(list((tmp_path / "plots").glob("*.png"))) == 4


def test_command_without_matplotlib_says_what_to_install(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, "matplotlib", None)
    monkeypatch.setitem(sys.modules, "matplotlib.figure", None)
    monkeypatch.delitem(sys.modules, "companion.experiments.linear.plots", raising=False)
    with pytest.raises(InputError, match=r"impromptu\[bench\]"):
        bench_linear.linear(json=None, output=tmp_path, seed=0)
