"""`companion train`: from a data set to the inverse network of the vehicle that flew it."""

from dataclasses import replace
from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console

from companion.cli import options
from companion.cli.lines import show
from companion.errors import InputError
from companion.learning.features import Preview
from companion.learning.inverse_network import AxisLoops
from companion.learning.model_file import save_model
from companion.learning.online_settings import PAPER
from companion.learning.training import PREVIEW, SAMPLE_TIME_S, estimated_preview, train_inverse_network
from companion.learning.training_data import plain_lag, without_acceleration
from companion.recording import Recording, read_recording
from companion.similarity.axis_loops import axis_loops


def train(
    datasets: Annotated[
        list[Path],
        typer.Argument(
            dir_okay=False, help="Recordings of `collect` or `fly`, .tlog or .ulg, of one vehicle."
        ),
    ],
    output: Annotated[Path, typer.Option(dir_okay=False, help="File for the model (safetensors).")],
    preview: Annotated[
        str | None,
        typer.Option(
            metavar="SECONDS|auto",
            help="How far ahead the network looks; auto: as the data ask for, else the preset's.",
        ),
    ] = None,
    preset: options.PresetOption = options.Preset.DEFAULT,
    name: options.VehicleName = None,
    system_id: Annotated[
        int | None,
        typer.Option(min=1, max=255, help="MAVLink id of the vehicle, in a telemetry log of several."),
    ] = None,
    seed: options.Seed = 0,
) -> None:
    """Train the inverse network of the vehicle that flew the data sets or flight logs, and write the model.

    Same data, same seed, same model. Needs torch; flying with the model does not. Of flights with and
    without acceleration the former teach, and the latter tell the lag that `lookahead` makes up for.

    Example: companion train ardrone2.mcap --output ardrone2.safetensors
    """
    console = Console()
    recordings = [_named(read_recording(each, system_id=system_id), name) for each in datasets]
    lookahead_s, loops = plain_lag(recordings), axis_loops(recordings[0])
    usual_preview, sample_time_s = PREVIEW, SAMPLE_TIME_S
    if preset is options.Preset.PAPER:
        usual_preview, sample_time_s = PAPER.preview, PAPER.sample_time_s
        recordings = list(map(without_acceleration, recordings))
    options.writable(output)
    with console.status("preparing the samples") as status:
        network = train_inverse_network(
            recordings,
            usual_preview if preview is None else _preview(preview, loops),
            sample_time_s,
            seed=seed,
            lookahead_s=lookahead_s,
            loops=loops,
            progress=lambda step, error: status.update(f"step {step}, held-out error {error:.4f}"),
        )
    save_model(network, output)
    card = network.card
    errors = (f"{name} {error:.3f}" for name, error in zip(card.outputs, card.held_out_rms, strict=True))
    lag = "" if lookahead_s is None else f", lag {lookahead_s:.2f} s"
    show(
        console,
        f"{card.vehicle}: {card.data_seconds:.0f} s of flight{lag}",
        f"held-out error: {', '.join(errors)}",
        f"model: {output}",
    )


def _preview(text: str, loops: AxisLoops | None) -> Preview:
    """What `--preview` means; InputError where it means nothing, or the data tell none."""
    if text == "auto":
        if loops is None:
            raise InputError("the first data set is too short to tell a preview from: give --preview SECONDS")
        return estimated_preview(loops)
    try:
        return Preview.of_time(float(text))
    except ValueError:
        raise InputError(f"--preview {text}: give seconds from 0 to 10, or auto") from None


def _named(recording: Recording, vehicle: str | None) -> Recording:
    """The recording, of a vehicle of that name where one is given."""
    if vehicle is None:
        return recording
    return replace(recording, provenance=recording.provenance.model_copy(update={"vehicle": vehicle}))
