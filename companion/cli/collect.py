"""`companion collect`: the flight that an inverse network learns from."""

from functools import partial
from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console

from companion.cli import options
from companion.cli.flying import Placed, Request, conduct, provenance, show, vehicle_name
from companion.flight.flight import FlightPlan
from companion.flight.guard import Fence, GuardLimits
from companion.flight.strategies import Strategy, reference_law
from companion.flight.technique import Technique
from companion.link import parse_address
from companion.trajectory import Limits, Trajectory, training_sinusoids
from companion.trajectory.training import LIMITS


def collect(
    connect: options.Connect,
    output: Annotated[Path, typer.Option(dir_okay=False, help="File for the data set (MCAP).")],
    box: Annotated[
        tuple[float, float, float],
        typer.Option(help="Sides of the box to fly in: north, east, up (m); its floor is 1.5 m up."),
    ] = (5.0, 5.0, 3.0),
    preset: Annotated[
        options.Preset,
        typer.Option(
            help="Whose network is to learn from it: ours, from a reference with acceleration "
            "(default, estimated), or the paper's, from one without (paper)."
        ),
    ] = options.Preset.DEFAULT,
    duration: Annotated[float, typer.Option(help="Length of the training trajectory (s).")] = 400.0,
    name: options.VehicleName = None,
    seed: options.Seed = 0,
    guard: options.Guard = None,
    land: options.Land = False,
    system_id: options.SystemId = None,
    signing_key: options.SigningKeyFile = None,
    forward: options.Forward = None,
) -> None:
    """Fly the training trajectory, sinusoids along all three axes, and write the data set.

    Ctrl-C ends the flight at any time: the vehicle is left in a hold, and what was flown is written.

    Example: companion collect --connect sitl://ardrone2 --output ardrone2.mcap
    """
    console = Console()
    address = parse_address(connect)
    guard_limits = options.guard_limits(guard) or GuardLimits()
    trajectory_within = partial(_training, duration, box, seed, guard_limits.fence)
    strategy = Strategy.BASELINE if preset is options.Preset.PAPER else Strategy.FEEDFORWARD
    plan = FlightPlan(
        trajectory_within(LIMITS),
        law=reference_law(strategy),
        limits=guard_limits,
        after=options.after(None, land=land),
    )
    about = provenance(address, name or vehicle_name(address), plan.trajectory.name, strategy)
    key = options.signing_key(signing_key)
    course, technique = Placed(plan, trajectory_within), Technique(strategy=strategy)
    request = Request(address, system_id, LIMITS, course, about, technique, key, forward or ())
    conduct(request, options.writable(output), console)
    show(console, f"next: companion train {output} --preset {preset} --output MODEL.safetensors")


def _training(
    duration_s: float, box_m: tuple[float, float, float], seed: int, fence: Fence, limits: Limits
) -> Trajectory:
    """The training trajectory within `limits`; InputError where it leaves the fence."""
    trajectory = training_sinusoids(duration_s, box_m, limits, seed)
    fence.require_inside(trajectory)
    return trajectory
