"""`companion similarity`: whether what one vehicle taught serves another."""

from functools import cache
from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console

from companion import __version__, bundled
from companion.cli import options
from companion.cli.lines import show
from companion.cli.result_file import write_result
from companion.errors import InputError
from companion.learning.model_file import load_model
from companion.recording import Recording, read_recording
from companion.similarity.comparison import compare
from companion.similarity.identification import VehicleModel, identify_recording
from companion.similarity.report import as_json, figures_table, remarks
from companion.similarity.track_record import (
    MEASURED,
    Pair,
    TrackRecord,
    network_helped,
    read_flown_pairs,
    track_record,
)
from companion.similarity.verdict import Judgement, verdict

RECORDINGS = (".mcap", ".tlog", ".ulg", ".xz")
MODEL = ".safetensors"
SIMULATED_S = 60.0


def similarity(
    source: Annotated[
        str, typer.Argument(help="Data set or flight log of the source, model, or name in config/vehicles.")
    ],
    target: Annotated[str, typer.Argument(help="The same of the target.")],
    flights: Annotated[
        Path | None,
        typer.Option(
            dir_okay=False,
            help="File of `companion bench transfer --json`: how often the verdict was right there.",
        ),
    ] = None,
    json: options.Json = None,
    system_id: options.SystemIdInLog = None,
    seed: options.Seed = 0,
) -> None:
    """Say how alike two vehicles are, and whether the network of one serves the other.

    Both closed loops, from reference to position, are identified from flights; docs/similarity.md says how to
    read the figures. A name, or a model's card, stands for a minute's flight of that simulated vehicle.

    Example: companion similarity ardrone2.mcap bebop2.mcap --json similarity.json
    """
    if json is not None:
        options.writable(json)
    console = Console()
    with console.status("identifying the source") as status:
        ours = _identified(source, system_id, seed)
        status.update("identifying the target")
        theirs = _identified(target, system_id, seed)
        status.update("comparing")
        axes = compare(ours, theirs)
        judgement = verdict(axes)
        if flights is None:
            record = MEASURED
        else:
            status.update("judging the pairs that were flown")
            record = _record(flights, seed)
    console.print(figures_table(axes))
    show(console, *remarks(axes, judgement, record))
    if json is not None:
        of = {"source": source, "target": target, "seconds": [ours.seconds, theirs.seconds]}
        write_result(of | as_json(axes, judgement, record) | {"software": __version__}, json)


def _identified(of: str, system_id: int | None, seed: int) -> VehicleModel:
    recording = _recording(of, system_id, seed)
    try:
        return identify_recording(recording, seed=seed)
    except InputError as error:
        raise InputError(f"{of}: {error}") from error


def _recording(of: str, system_id: int | None, seed: int) -> Recording:
    """A flight of what was named: a file's, or a simulated one."""
    path = Path(of)
    if path.suffix == MODEL:
        return _simulated(load_model(bundled.find("models", of, MODEL)).card.vehicle, "ideal", seed)
    if path.suffix in RECORDINGS:
        return read_recording(path, system_id=system_id)
    return _simulated(of, "ideal", seed)


def _simulated(vehicle: str, conditions: str, seed: int) -> Recording:
    """The training trajectory, flown by a simulated vehicle."""
    try:
        from companion.experiments.simulated_flights import Scenario, prepare_simulator, simulate
        from companion.flight.strategies import Strategy
        from companion.trajectory import training_sinusoids
        from companion.trajectory.training import LIMITS
    except ModuleNotFoundError as missing:
        raise InputError(
            f"{vehicle} stands for a simulated flight, which needs {missing.name}: give a recording, or "
            "pip install 'impromptu[bench]'"
        ) from missing
    prepare_simulator([vehicle], conditions)
    trajectory = training_sinusoids(SIMULATED_S, (5.0, 5.0, 3.0), LIMITS, seed)
    outcome, _, _ = simulate(Scenario(trajectory, Strategy.FEEDFORWARD, vehicle, conditions, seed))
    return outcome.recording


def _record(file: Path, seed: int) -> TrackRecord:
    helped = network_helped(read_flown_pairs(file).rows)

    @cache
    def model(vehicle: str, conditions: str) -> VehicleModel:
        return identify_recording(_simulated(vehicle, conditions, seed), resamples=0)

    def judged(pair: Pair) -> Judgement:
        return verdict(compare(model(pair.source, "ideal"), model(pair.target, pair.conditions)))

    return track_record(str(file), {pair: judged(pair).verdict for pair in helped}, helped)
