"""From a data set to a model to a flight with it."""

from functools import partial
from pathlib import Path

import numpy as np
import pytest
from command_line import Run

from companion.learning import training
from companion.learning.features import ACCELERATING_OUTPUTS, INVERSE_OUTPUTS, Preview
from companion.learning.model_file import load_model
from companion.learning.online_settings import PAPER
from companion.recording import read_recording


@pytest.fixture
def short_training(monkeypatch: pytest.MonkeyPatch) -> None:
    """A network so small that it takes no time."""
    monkeypatch.setattr(training, "train", partial(training.train, hidden_layers=(8,)))


@pytest.mark.usefixtures("short_training")
def test_collect_train_fly(companion: Run, tmp_path: Path) -> None:
    dataset, model = tmp_path / "data.mcap", tmp_path / "new" / "model.safetensors"
    ran = companion(
        *("collect", "--connect", "sitl://ardrone2", "--output", dataset),
        *("--duration", 12, "--box", 3, 3, 2, "--name", "mine", "--land"),
    )
    assert ran.status == 0, ran.err
    assert "tracking training for 12.0 s" in ran.out
    assert f"companion train {dataset}" in ran.out
    recording = read_recording(dataset)
    assert recording.provenance.vehicle == "mine"
    assert recording.provenance.strategy == "feedforward"
    assert recording.states.position[:, 2].min() > -4.5

    ran = companion("train", dataset, "--output", model, "--preview", 0.3, "--seed", 7)
    assert ran.status == 0, ran.err
    assert "held-out error" in ran.out
    card = load_model(model).card
    assert (card.vehicle, card.seed, card.preview) == ("mine", 7, Preview.of_time(0.3))
    assert card.outputs == ACCELERATING_OUTPUTS

    for strategy in ([], ["--strategy", "lookahead"]):
        ran = companion("fly", "clef", "--model", model, "--dry-run", *strategy)
        assert ran.status == 0, ran.err


def test_the_flight_for_the_papers_network_has_no_acceleration(companion: Run, tmp_path: Path) -> None:
    dataset = tmp_path / "data.mcap"
    collect = ("collect", "--connect", "sitl://ardrone2", "--duration", 8, "--output", dataset)
    ran = companion(*collect, "--preset", "paper")
    assert ran.status == 0, ran.err
    recording = read_recording(dataset)
    assert recording.provenance.strategy == "baseline"
    assert np.isnan(recording.references.acceleration).all()


@pytest.mark.usefixtures("short_training")
def test_the_papers_network_learns_no_acceleration(companion: Run, tmp_path: Path) -> None:
    dataset, model = tmp_path / "data.mcap", tmp_path / "model.safetensors"
    ran = companion("collect", "--connect", "sitl://ardrone2", "--duration", 30, "--output", dataset)
    assert ran.status == 0, ran.err
    assert np.isfinite(read_recording(dataset).references.acceleration).any()
    ran = companion("train", dataset, "--preset", "paper", "--output", model)
    assert ran.status == 0, ran.err
    card = load_model(model).card
    assert card.outputs == INVERSE_OUTPUTS
    assert card.preview == PAPER.preview


@pytest.mark.parametrize(
    ("arguments", "expected"),
    [
        (("--guard", "{guard}"), "leaves the fence"),
        (("--box", "0", "5", "3"), "training box"),
        (("--duration", "1"), "too short"),
        (("--output", "/proc/nothing/data.mcap"), "cannot be written"),
    ],
)
def test_a_data_set_that_cannot_be_flown_is_refused(
    companion: Run, tmp_path: Path, arguments: tuple[str, ...], expected: str
) -> None:
    guard = tmp_path / "guard.yaml"
    guard.write_text("fence: {altitude_m: [0.5, 3.0]}")
    usual = ("collect", "--connect", "sitl://bebop2", "--output", tmp_path / "data.mcap", "--duration", 20)
    ran = companion(*usual, *(argument.format(guard=guard) for argument in arguments))
    assert ran.status == 2
    assert expected in ran.err
    assert "arming" not in ran.out


def test_training_on_what_is_no_data_set_is_refused(companion: Run, tmp_path: Path) -> None:
    file, model = tmp_path / "data.mcap", tmp_path / "model.safetensors"
    ran = companion("train", file, "--output", model)
    assert ran.status == 2
    assert "data.mcap" in ran.err
    assert not model.exists()
