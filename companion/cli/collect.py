"""`companion collect`: the flight that an inverse network learns from."""

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Annotated, Any, TypeAlias

import numpy as np
import typer
from rich.console import Console

from companion.cli import options
from companion.cli.flying import Placed, Request, conduct, provenance, vehicle_name
from companion.cli.lines import show
from companion.errors import InputError
from companion.flight.flight import FlightPlan
from companion.flight.guard import GuardLimits, require_flyable
from companion.flight.strategies import Strategy, reference_law
from companion.flight.technique import Technique
from companion.link import parse_address
from companion.link.address import Address, Simulated
from companion.trajectory import Limits, Trajectory, training_sinusoids
from companion.trajectory.training import LIMITS

_Box: TypeAlias = Annotated[
    tuple[float, float, float],
    typer.Option(help="Sides of the box to fly in: north, east, up (m); its floor is 1.5 m up."),
]
_Preset: TypeAlias = Annotated[
    options.Preset,
    typer.Option(
        help="Whose network is to learn from it: ours, from a reference with acceleration "
        "(default, estimated), or the paper's, from one without (paper)."
    ),
]
_Flights: TypeAlias = Annotated[
    int,
    typer.Option(min=1, max=100, help="How many, along other sinusoids each; only of the built-in vehicle."),
]
_Randomise: TypeAlias = Annotated[
    float,
    typer.Option(
        min=0.0,
        max=0.5,
        help="Spread of the built-in vehicle's mass and drag, drawn anew for each flight: 0.2 is 20 % either "
        "way, and up to 20 ms of delay.",
    ),
]


def collect(
    connect: options.Connect,
    output: Annotated[Path, typer.Option(dir_okay=False, help="File for the data set (MCAP).")],
    box: _Box = (5.0, 5.0, 3.0),
    preset: _Preset = options.Preset.DEFAULT,
    duration: Annotated[float, typer.Option(help="Length of the training trajectory (s).")] = 400.0,
    flights: _Flights = 1,
    randomise: _Randomise = 0.0,
    name: options.VehicleName = None,
    seed: options.Seed = 0,
    guard: options.Guard = None,
    land: options.Land = False,
    system_id: options.SystemId = None,
    signing_key: options.SigningKeyFile = None,
    forward: options.Forward = None,
    accept_failsafe: options.AcceptFailsafe = False,
) -> None:
    """Fly the training trajectory, sinusoids along all three axes, and write the data set.

    Ctrl-C ends the flight at any time: the vehicle is left in a hold, and what was flown is written. Each of
    several flights has a numbered file of its own.

    Example: companion collect --connect sitl://ardrone2 --output ardrone2.mcap
    """
    console = Console()
    address = parse_address(connect)
    if not isinstance(address, Simulated) and (flights > 1 or randomise):
        raise InputError(
            "--flights and --randomise are for the built-in vehicle, sitl://NAME: leave them out"
        )
    guard_limits = options.guard_limits(guard) or GuardLimits()
    strategy = Strategy.BASELINE if preset is options.Preset.PAPER else Strategy.FEEDFORWARD
    key = options.signing_key(signing_key)
    files = _files(output, flights)
    for number, file in enumerate(map(options.writable, files)):
        trajectory_within = partial(_training, duration, box, seed + number, guard_limits)
        plan = FlightPlan(
            trajectory_within(LIMITS),
            law=reference_law(strategy),
            limits=guard_limits,
            after=options.after(None, land=land),
        )
        with _drawn(_later(address, number), randomise, seed + number) as (flown, variation):
            about = provenance(flown, name or vehicle_name(address), plan.trajectory.name, strategy)
            request = Request(
                *(flown, system_id, LIMITS, Placed(plan, trajectory_within)),
                *(about.model_copy(update=variation), Technique(strategy=strategy), key, forward or ()),
                accept_failsafe=accept_failsafe,
            )
            conduct(request, file, console)
    data_sets = " ".join(map(str, files))
    show(console, f"next: companion train {data_sets} --preset {preset} --output MODEL.safetensors")


def _files(output: Path, flights: int) -> list[Path]:
    """`output`, or for several flights as many with a number behind the name."""
    if flights == 1:
        return [output]
    return [output.with_stem(f"{output.stem}-{number}") for number in range(1, flights + 1)]


def _later(address: Address, number: int) -> Address:
    """The same vehicle on its flight of that number: what is random about it comes out otherwise."""
    return replace(address, seed=address.seed + number) if isinstance(address, Simulated) else address


@contextmanager
def _drawn(address: Address, spread: float, seed: int) -> Iterator[tuple[Address, dict[str, Any]]]:
    """What is flown in place of the vehicle at `address`, and what its recording says of the difference."""
    if not isinstance(address, Simulated) or not spread:
        yield address, {}
        return
    from companion.experiments.randomised import drawn, varied_file

    variation = drawn(spread, np.random.default_rng(seed))
    with varied_file(address.vehicle, variation) as path:
        yield replace(address, vehicle=str(path)), {"randomised": variation._asdict()}


def _training(
    duration_s: float, box_m: tuple[float, float, float], seed: int, guard: GuardLimits, limits: Limits
) -> Trajectory:
    """The training trajectory within `limits`; InputError where the guard would have to clip it."""
    trajectory = training_sinusoids(duration_s, box_m, limits, seed)
    require_flyable(trajectory, guard)
    return trajectory
