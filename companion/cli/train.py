"""`companion train`: from a data set to the inverse network of the vehicle that flew it."""

from dataclasses import replace
from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console

from companion.cli import options
from companion.cli.flying import show
from companion.learning.features import Preview
from companion.learning.model_file import save_model
from companion.learning.online_settings import PAPER
from companion.learning.training import PREVIEW, SAMPLE_TIME_S, train_inverse_network
from companion.learning.training_data import without_acceleration
from companion.recording import Recording, read_recording


def train(
    dataset: Annotated[
        Path, typer.Argument(dir_okay=False, help="Recording of `collect` or `fly`, .tlog or .ulg.")
    ],
    output: Annotated[Path, typer.Option(dir_okay=False, help="File for the model (safetensors).")],
    preview: Annotated[
        float | None,
        typer.Option(min=0.01, max=5.0, help="How far ahead the network looks (s); else the preset's."),
    ] = None,
    preset: options.PresetOption = options.Preset.DEFAULT,
    name: options.VehicleName = None,
    system_id: Annotated[
        int | None,
        typer.Option(min=1, max=255, help="MAVLink id of the vehicle, in a telemetry log of several."),
    ] = None,
    seed: options.Seed = 0,
) -> None:
    """Train the inverse network of the vehicle that flew a data set or a flight log, and write the model.

    Same data, same seed, same model. Needs torch; flying with the model does not.

    Example: companion train ardrone2.mcap --output ardrone2.safetensors
    """
    console = Console()
    if preset is options.Preset.PAPER:
        usual_preview, sample_time_s = PAPER.preview, PAPER.sample_time_s
    else:
        usual_preview, sample_time_s = PREVIEW, SAMPLE_TIME_S
    recording = _named(read_recording(dataset, system_id=system_id), name)
    if preset is options.Preset.PAPER:
        recording = without_acceleration(recording)
    options.writable(output)
    with console.status("preparing the samples") as status:
        network = train_inverse_network(
            recording,
            usual_preview if preview is None else Preview.of_time(preview),
            sample_time_s,
            seed=seed,
            progress=lambda step, error: status.update(f"step {step}, held-out error {error:.4f}"),
        )
    save_model(network, output)
    card = network.card
    errors = (f"{name} {error:.3f}" for name, error in zip(card.outputs, card.held_out_rms, strict=True))
    show(
        console,
        f"{card.vehicle}: {card.data_seconds:.0f} s of flight, lag {card.lookahead_s:.2f} s",
        f"held-out error: {', '.join(errors)}",
        f"model: {output}",
    )


def _named(recording: Recording, vehicle: str | None) -> Recording:
    """The recording, of a vehicle of that name where one is given."""
    if vehicle is None:
        return recording
    return replace(recording, provenance=recording.provenance.model_copy(update={"vehicle": vehicle}))
