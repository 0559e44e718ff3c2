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
from companion.learning.training import estimated_preview
from companion.recording import Provenance, Recording, read_recording, write_recording
from companion.recording.series import ReferenceSeries, StateSeries


def hover() -> Recording:
    """Two seconds in one place."""
    time_s, still = np.arange(0.0, 2.0, 0.02), np.zeros((100, 3))
    return Recording(
        Provenance(vehicle="still"),
        StateSeries(time_s, still, still, still, still),
        ReferenceSeries(time_s, still, still, still, np.zeros(100)),
    )


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

    ran = companion("fly", "clef", "--model", model, "--dry-run")
    assert ran.status == 0, ran.err
    ran = companion("fly", "clef", "--model", model, "--dry-run", "--strategy", "lookahead")
    assert ran.status == 2
    assert "give --lookahead SECONDS" in ran.err


def test_the_flight_for_the_papers_network_has_no_acceleration(companion: Run, tmp_path: Path) -> None:
    dataset = tmp_path / "data.mcap"
    collect = ("collect", "--connect", "sitl://ardrone2", "--duration", 8, "--output", dataset)
    ran = companion(*collect, "--preset", "paper")
    assert ran.status == 0, ran.err
    recording = read_recording(dataset)
    assert recording.provenance.strategy == "baseline"
    assert np.isnan(recording.references.acceleration).all()


@pytest.mark.usefixtures("short_training")
def test_several_flights_of_randomised_vehicles_make_one_network(companion: Run, tmp_path: Path) -> None:
    model = tmp_path / "model.safetensors"
    collect = ("collect", "--connect", "sitl://ardrone2", "--duration", 8)
    ran = companion(*collect, "--flights", 2, "--randomise", 0.2, "--output", tmp_path / "data.mcap")
    assert ran.status == 0, ran.err
    files = [tmp_path / "data-1.mcap", tmp_path / "data-2.mcap"]
    assert f"companion train {files[0]} {files[1]}" in ran.out
    first, second = (read_recording(file).provenance for file in files)
    assert (first.vehicle, second.vehicle) == ("ardrone2", "ardrone2")
    assert (first.seed, second.seed) == (0, 1)
    assert first.model_extra is not None
    assert second.model_extra is not None
    assert 0.8 <= first.model_extra["randomised"]["mass"] <= 1.2
    assert first.model_extra["randomised"] != second.model_extra["randomised"]

    plain = tmp_path / "plain.mcap"
    ran = companion(*collect, "--preset", "paper", "--output", plain)
    assert ran.status == 0, ran.err
    ran = companion("train", *files, plain, "--output", model, "--preview", "auto")
    assert ran.status == 0, ran.err
    card = load_model(model).card
    assert (card.data_flights, card.vehicle, card.outputs) == (2, "ardrone2", ACCELERATING_OUTPUTS)
    assert card.lookahead_s is not None
    assert card.lookahead_s > 0.2
    assert card.loops is not None
    assert card.preview == estimated_preview(card.loops)


@pytest.mark.parametrize("option", [("--flights", 2), ("--randomise", 0.2)])
def test_only_the_built_in_vehicle_is_randomised(
    companion: Run, tmp_path: Path, option: tuple[str, float]
) -> None:
    ran = companion(
        "collect", "--connect", "udpin://127.0.0.1:14999", "--output", tmp_path / "data.mcap", *option
    )
    assert ran.status == 2
    assert "built-in vehicle" in ran.err


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


@pytest.mark.parametrize("preview", ["soon", "-1", "nan", "100"])
def test_a_preview_that_means_nothing_is_refused(companion: Run, tmp_path: Path, preview: str) -> None:
    dataset = tmp_path / "data.mcap"
    write_recording(hover(), dataset)
    ran = companion("train", dataset, "--output", tmp_path / "model", f"--preview={preview}")
    assert ran.status == 2
    assert "give seconds from 0 to 10, or auto" in ran.err


def test_training_on_what_is_no_data_set_is_refused(companion: Run, tmp_path: Path) -> None:
    file, model = tmp_path / "data.mcap", tmp_path / "model.safetensors"
    ran = companion("train", file, "--output", model)
    assert ran.status == 2
    assert "data.mcap" in ran.err
    assert not model.exists()
