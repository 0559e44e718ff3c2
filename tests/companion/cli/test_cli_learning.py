"""From a data set to a model to a flight with it."""

from functools import partial
from pathlib import Path

import pytest
from command_line import Run

from companion.learning import training
from companion.learning.features import Preview
from companion.learning.model_file import load_model
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
    assert recording.provenance.strategy == "baseline"
    assert recording.states.position[:, 2].min() > -4.5

    ran = companion("train", dataset, "--output", model, "--preview", 0.3, "--seed", 7)
    assert ran.status == 0, ran.err
    assert "held-out error" in ran.out
    card = load_model(model).card
    assert (card.vehicle, card.seed, card.preview) == ("mine", 7, Preview.of_time(0.3))

    for strategy in ([], ["--strategy", "lookahead"]):
        ran = companion("fly", "clef", "--model", model, "--dry-run", *strategy)
        assert ran.status == 0, ran.err


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
