"""`companion bench step`: what one control step costs."""

from dataclasses import asdict
from typing import Annotated

import typer
from rich.box import SIMPLE_HEAD
from rich.console import Console
from rich.table import Table

from companion import __version__
from companion.cli import options
from companion.cli.result_file import write_result
from companion.errors import InputError
from companion.flight.strategies import Strategy

try:
    from companion.experiments.contenders import find_model, needs_network
    from companion.experiments.simulated_flights import Scenario, prepare_simulator
    from companion.experiments.step_cost import step_cost
    from companion.trajectory.training import training_sinusoids
except ModuleNotFoundError as missing:
    raise InputError(
        f"the benchmark needs {missing.name}, which is not installed: pip install 'impromptu[bench]'"
    ) from missing


def step(
    vehicle: Annotated[
        str, typer.Option(help="Simulated vehicle: a name in config/vehicles, or a YAML file.")
    ] = "bebop2",
    model: Annotated[
        str, typer.Option(help="Inverse network: a name in config/models, or a file.")
    ] = "ardrone2",
    strategy: Annotated[Strategy, typer.Option(help="Whose steps.")] = Strategy.DNN_GP,
    conditions: options.Conditions = "realistic",
    preset: options.PresetOption = options.Preset.DEFAULT,
    settings: options.SettingsFile = None,
    duration: Annotated[float, typer.Option(help="Length of the flight (s).")] = 60.0,
    seed: options.Seed = 0,
    json: options.Json = None,
) -> None:
    """Measure what this computer takes for one control step, on one core.

    A simulated flight's states are fed to the control loop once more, as fast as it takes them: online
    correction with a full window, network, guard, records.

    Example: companion bench step --json step.json
    """
    if json is not None:
        options.writable(json)
    console = Console()
    online = options.online_settings(preset, settings)
    with console.status(f"Flying {duration:g} s of sinusoids, and computing the flight again"):
        prepare_simulator([vehicle], conditions)
        scenario = Scenario(
            training_sinusoids(duration),
            strategy,
            vehicle=vehicle,
            conditions=conditions,
            seed=seed,
            network=find_model(model, online).network if needs_network(strategy) else None,
            online=online,
        )
        cost = step_cost(scenario)
    table = Table(box=SIMPLE_HEAD, caption=f"milliseconds a step, {cost.steps} steps")
    for heading in ("", "median", "99 %", "longest"):
        table.add_column(heading, justify="right")
    for name, spread in (("elapsed", cost.elapsed_ms), ("processor", cost.processor_ms)):
        table.add_row(name, *(f"{each:.3f}" for each in (spread.p50, spread.p99, spread.max)))
    console.print(table)
    if json is not None:
        asked = {
            "vehicle": vehicle,
            "model": model,
            "strategy": strategy,
            "conditions": conditions,
            "preset": preset,
            "settings": None if settings is None else online.model_dump(mode="json"),
            "duration_s": duration,
            "seed": seed,
        }
        write_result(asdict(cost) | {"settings": asked, "software": __version__}, json)
