"""`companion fly`: one trajectory on one vehicle, and how closely it was tracked."""

from collections.abc import Callable, Iterator
from dataclasses import asdict
from functools import partial
from pathlib import Path
from typing import Annotated, Any, TypeAlias

import typer
from rich.console import Console

from companion import bundled
from companion.cli import options
from companion.cli.fly_plan import Planned, is_plan
from companion.cli.flying import Course, Flown, Placed, Request, conduct, provenance, vehicle_name
from companion.cli.lines import show
from companion.cli.recorded import usual_path
from companion.cli.result_file import write_result
from companion.errors import GapError, InputError, TakenError
from companion.flight.flight import After, FlightOutcome, FlightPlan
from companion.flight.guard import GuardLimits, require_flyable
from companion.flight.heading import YawMode
from companion.flight.online_correction import OnlineCorrection
from companion.flight.strategies import ReferenceLaw, Strategy, reference_law
from companion.flight.supervision import supervision_of
from companion.flight.technique import Technique
from companion.learning.inverse_network import InverseNetwork
from companion.learning.library import Library
from companion.learning.online_settings import OnlineSettings
from companion.link import parse_address
from companion.link.address import Address
from companion.mission.files import read_plan
from companion.recording import Provenance
from companion.trajectory import Limits, Placement, Trajectory, read_trajectory
from companion.trajectory.placement import LOWEST_M

_WITH_MODEL = (Strategy.LOOKAHEAD, Strategy.DNN, Strategy.DNN_GP)

_StrategyOption: TypeAlias = Annotated[
    Strategy | None, typer.Option(help="How to track; dnn+gp where a model is given, else gp.")
]
_Lookahead: TypeAlias = Annotated[
    float | None, typer.Option(min=0.0, max=5.0, help="For lookahead: how early (s); else the model's.")
]
_After: TypeAlias = Annotated[
    After | None,
    typer.Option(help="How to hand the vehicle back: hold, land, or return to its takeoff point."),
]
_Yaw: TypeAlias = Annotated[
    YawMode, typer.Option(help="Where the nose points: as found (hold), or along the path (path).")
]
_Resume: TypeAlias = Annotated[
    bool,
    typer.Option(
        "--resume", help="Take over a vehicle in the air, and go on at the trajectory's nearest point."
    ),
]
_DryRun: TypeAlias = Annotated[
    bool, typer.Option("--dry-run", help="Show what would be flown, and connect to nothing.")
]
_Record: TypeAlias = Annotated[
    Path | None,
    typer.Option(
        dir_okay=False, help="Write the flight's recording to this file (MCAP), its link to a .tlog beside."
    ),
]
_LogDir: TypeAlias = Annotated[
    Path,
    typer.Option(
        "--log-dir",
        file_okay=False,
        envvar="IMPROMPTU_LOG_DIR",
        help="Folder for what --record does not name; of the built-in vehicle, only that is recorded.",
    ),
]


def fly(
    trajectory: Annotated[
        str, typer.Argument(help="CSV file, a name in config/trajectories, or a mission: .plan, .waypoints.")
    ],
    connect: options.ConnectUnlessDry = None,
    strategy: _StrategyOption = None,
    model: options.Model = None,
    lookahead: _Lookahead = None,
    size: options.Size = 3.0,
    speed: options.Speed = None,
    plane: options.PlaneOption = options.Plane.XZ,
    origin: options.Origin = (0.0, 0.0),
    heading: options.Heading = 0.0,
    altitude: options.Altitude = LOWEST_M,
    flip_y: options.FlipY = False,
    yaw: _Yaw = YawMode.HOLD,
    land: options.Land = False,
    after: _After = None,
    resume: _Resume = False,
    preset: options.PresetOption = options.Preset.DEFAULT,
    settings: options.SettingsFile = None,
    guard: options.Guard = None,
    system_id: options.SystemId = None,
    signing_key: options.SigningKeyFile = None,
    forward: options.Forward = None,
    accept_failsafe: options.AcceptFailsafe = False,
    dry_run: _DryRun = False,
    record: _Record = None,
    log_dir: _LogDir = Path("flights"),
    json: options.Json = None,
) -> None:
    """Take off, go to the start, track the trajectory, hold; and say how closely it was tracked.

    Ctrl-C ends the flight at any time: the vehicle is left in a hold. A model looks as far ahead as it was
    trained to, whatever the preset of the online correction.

    A mission plan may lead up to 500 m away, within its own fence and the vehicle's; setpoints stay in a box
    5 m beyond its waypoints. Other limits are set by --guard, whose fence then counts for plans, too.

    Example: companion fly clef --connect sitl://bebop2 --model ardrone2

    Example: companion fly drawing.csv --connect udpin://0.0.0.0:14540 --size 2 --land

    Example: companion fly survey.plan --connect udpin://0.0.0.0:14540 --strategy dnn+gp --model ardrone2
    """
    console = Console()
    limits, guard_limits = options.limits(speed), options.guard_limits(guard)
    online = options.online_settings(preset, settings)
    network = options.network(model, online)
    strategy, law = _technique(strategy, network, lookahead, online)
    flight = partial(
        FlightPlan,
        law=law,
        correction=OnlineCorrection(online) if strategy.learns_online else None,
        supervision=supervision_of(strategy, network, online),
        period_s=strategy.period_s(online),
        yaw=yaw,
        resume=resume,
    )
    placement = options.placement(size, plane, origin, heading, altitude, flip_y)
    asked = options.after(after, land=land) if after or land else None
    course = _course(trajectory, flight, limits, guard_limits, placement, asked, resume)
    if dry_run:
        show(console, *course.preview(limits))
        return
    address = _address(connect)
    record = record or usual_path(address, log_dir, f"{course.name}-{strategy}")
    for path in filter(None, (record, json)):
        options.writable(path)
    show(console, f"strategy: {strategy}" + (f", model {model}" if model else ""))
    about = provenance(address, vehicle_name(address), course.name, strategy)
    key = options.signing_key(signing_key)
    technique = Technique(
        strategy=strategy,
        online=online,
        lookahead_s=lookahead,
        model=model,
        model_sha256=options.model_sha256(model),
    )
    request = Request(
        *(address, system_id, limits, course, about, technique, key, forward or ()),
        accept_failsafe=accept_failsafe,
        notes=log_dir,
        network=None if strategy is Strategy.LOOKAHEAD else network,
    )
    flown = _conduct(request, record, console)
    show(console, *_lines(flown.outcome))
    if json is not None:
        write_result(_result(flown, about, model), json)


def _course(
    trajectory: str,
    flight: Callable[..., FlightPlan],
    limits: Limits,
    guard: GuardLimits | None,
    placement: Placement,
    after: After | None,
    resume: bool,
) -> Course:
    """What to fly, from the file that `trajectory` names; InputError where that cannot be flown."""
    if is_plan(trajectory):
        file = Path(trajectory)
        return Planned(file.stem, read_plan(file), flight, guard, after, resume)
    file = bundled.find("trajectories", trajectory, ".csv")
    guard = guard or GuardLimits()
    within = partial(_read, file, placement, guard)
    return Placed(flight(within(limits), limits=guard, after=after or After.HOLD), within)


def _address(connect: str | None) -> Address:
    if connect is None:
        raise InputError("where is the vehicle? Give --connect URL, or --dry-run to look only")
    return parse_address(connect)


def _conduct(request: Request, record: Path | None, console: Console) -> Flown:
    """`conduct`; where the vehicle left our control, how to go on is shown too."""
    try:
        return conduct(request, record, console)
    except (TakenError, GapError):
        show(console, "nothing more is sent: the same command with --resume goes on where the vehicle is")
        raise


def _read(file: Path, placement: Placement, guard: GuardLimits, limits: Limits) -> Trajectory:
    """The trajectory in the file; InputError where it is none, or the guard would have to clip it."""
    trajectory = read_trajectory(file, placement, limits)
    require_flyable(trajectory, guard)
    return trajectory


def _technique(
    strategy: Strategy | None,
    network: InverseNetwork | Library | None,
    lookahead_s: float | None,
    online: OnlineSettings,
) -> tuple[Strategy, ReferenceLaw]:
    """The strategy that is meant, and how it makes u1; InputError where the options contradict."""
    if strategy is None:
        strategy = Strategy.GP if network is None else Strategy.DNN_GP
    if network is not None and strategy not in _WITH_MODEL:
        raise InputError(f"strategy {strategy} uses no model: leave out --model, or choose another strategy")
    if lookahead_s is not None and strategy is not Strategy.LOOKAHEAD:
        raise InputError(f"--lookahead belongs to strategy lookahead, not to {strategy}")
    if lookahead_s is None and isinstance(network, InverseNetwork):
        lookahead_s = network.card.lookahead_s
    law = reference_law(strategy, network=network, lookahead_s=lookahead_s, online=online)
    return strategy, law


def _lines(outcome: FlightOutcome) -> Iterator[str]:
    """The result for people."""
    accuracy = outcome.accuracy
    north, east, down = accuracy.rms_axes_m
    yield (
        f"tracking error: RMS {accuracy.rms_m:.3f} m (north {north:.3f}, east {east:.3f}, down {down:.3f}), "
        f"maximum {accuracy.max_m:.3f} m"
    )
    for clip, count in outcome.clips.items():
        yield f"guard: {clip}, {count} times"


def _result(flown: Flown, about: Provenance, model: str | None) -> dict[str, Any]:
    """The result for programs."""
    outcome, accuracy = flown.outcome, flown.outcome.accuracy
    return {
        "strategy": about.strategy,
        "model": model,
        "trajectory": about.trajectory,
        "vehicle": {"name": about.vehicle, "system_id": flown.system_id, **asdict(flown.identity)},
        "rms_m": accuracy.rms_m,
        "rms_axes_m": accuracy.rms_axes_m.tolist(),
        "max_m": accuracy.max_m,
        "duration_s": outcome.trajectory.duration_s,
        "clips": {str(clip): count for clip, count in outcome.clips.items()},
        "events": [
            {"time_s": time_s - outcome.start_s, "text": text} for time_s, text in outcome.recording.events
        ],
        "conditions": about.conditions,
        "seed": about.seed,
        "software": about.software,
        "recording": None if flown.recording is None else str(flown.recording),
    }
