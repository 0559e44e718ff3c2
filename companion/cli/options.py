"""Options that several subcommands share, and what they mean."""

import hashlib
import math
from enum import StrEnum
from pathlib import Path
from typing import Annotated, TypeAlias

import typer

from companion import bundled
from companion.errors import InputError
from companion.flight.flight import After
from companion.flight.guard import GuardLimits
from companion.flight.guard_file import read_guard_limits
from companion.learning.inverse_network import InverseNetwork
from companion.learning.library import AUTO, Library, library_files, load_library
from companion.learning.model_file import load_model
from companion.learning.online_settings import DEFAULT, ESTIMATED, PAPER, OnlineSettings
from companion.link.signing import SigningKey
from companion.link.signing_key import read_signing_key
from companion.trajectory.limits import Limits
from companion.trajectory.placement import LOWEST_M, Placement
from companion.yaml_file import read_settings

_MODELS = bundled.config_directory() / "models"


class Plane(StrEnum):
    """In which plane a drawing is laid."""

    XZ = "xz"
    XY = "xy"


class Preset(StrEnum):
    """Whose settings of the online correction."""

    DEFAULT = "default"
    ESTIMATED = "estimated"
    PAPER = "paper"

    @property
    def settings(self) -> OnlineSettings:
        """The settings."""
        return {Preset.DEFAULT: DEFAULT, Preset.ESTIMATED: ESTIMATED, Preset.PAPER: PAPER}[self]


_CONNECT = typer.Option(
    "--connect",
    metavar="URL",
    help="Where the vehicle is: udpin://0.0.0.0:14540, udpout://HOST:PORT, tcpout://HOST:5760, "
    "serial:///dev/ttyS0:57600, or the built-in one: sitl://bebop2 with ?conditions=windy&seed=1 behind it.",
)
Connect: TypeAlias = Annotated[str, _CONNECT]
ConnectUnlessDry: TypeAlias = Annotated[str | None, _CONNECT]
SystemId: TypeAlias = Annotated[
    int | None,
    typer.Option(min=1, max=255, help="MAVLink id of the vehicle; without it, the first that is heard."),
]
SigningKeyFile: TypeAlias = Annotated[
    Path | None,
    typer.Option(
        "--signing-key",
        dir_okay=False,
        metavar="FILE",
        help="Sign what is sent, and believe nothing but what is signed with the key in this file "
        "(mode 0600): 32 bytes in hex or base64, or a passphrase.",
    ),
]
Forward: TypeAlias = Annotated[
    list[str] | None,
    typer.Option(
        "--forward",
        metavar="URL",
        help="Let a ground station share the link: udpout://HOST:14550, tcpin://0.0.0.0:5760; "
        "may be given several times.",
    ),
]
AcceptFailsafe: TypeAlias = Annotated[
    bool,
    typer.Option(
        "--accept-failsafe",
        help="Fly although the autopilot would do something unsafe when setpoints stop (docs/safety.md).",
    ),
]
SystemIdInLog: TypeAlias = Annotated[
    int | None,
    typer.Option(
        "--system-id", min=1, max=255, help="MAVLink id of the vehicle, in a telemetry log of several."
    ),
]
Json: TypeAlias = Annotated[Path | None, typer.Option(dir_okay=False, help="Write the result to this file.")]
Size: TypeAlias = Annotated[float, typer.Option(help="Longest side of a drawing (m).")]
Speed: TypeAlias = Annotated[float | None, typer.Option(help="Peak speed (m/s); 1.2 for drawings.")]
PlaneOption: TypeAlias = Annotated[
    Plane, typer.Option(help="Plane of a drawing: upright (xz) or level (xy).")
]
Origin: TypeAlias = Annotated[
    tuple[float, float], typer.Option(help="North and east of the drawing's centre from takeoff (m).")
]
Heading: TypeAlias = Annotated[
    float, typer.Option(help="Direction of the drawing's x axis, degrees clockwise from north.")
]
Altitude: TypeAlias = Annotated[
    float, typer.Option(help=f"Height of the drawing's lowest point above takeoff (m, at least {LOWEST_M}).")
]
FlipY: TypeAlias = Annotated[bool, typer.Option("--flip-y", help="The drawing's y points down.")]
Model: TypeAlias = Annotated[
    str | None,
    typer.Option(
        help="Inverse network: a name in config/models, or a file; or `auto`, which of all in config/models "
        "follows the one that helps most."
    ),
]
PresetOption: TypeAlias = Annotated[
    Preset,
    typer.Option(
        help="Settings of the online correction: ours (default), ours with the gain that the model "
        "estimates (estimated), or exactly the paper's (paper)."
    ),
]
SettingsFile: TypeAlias = Annotated[
    Path | None,
    typer.Option(
        "--settings",
        dir_okay=False,
        metavar="FILE",
        help="Settings of the online correction that differ from the preset's, in YAML; config/online.yaml "
        "shows the keys.",
    ),
]
Guard: TypeAlias = Annotated[
    Path | None,
    typer.Option(dir_okay=False, help="Limits of the guard, in YAML; config/guard.yaml shows the keys."),
]
Land: TypeAlias = Annotated[bool, typer.Option("--land", help="Land afterwards, where a hold is usual.")]
VehicleName: TypeAlias = Annotated[
    str | None, typer.Option("--name", help="What to call the vehicle in the file.")
]
Seed: TypeAlias = Annotated[int, typer.Option(min=0, help="Of everything random.")]
Drawing: TypeAlias = Annotated[str, typer.Option(help="CSV file, or drawing of config/trajectories.")]
SimulatedVehicle: TypeAlias = Annotated[str, typer.Option(help="A name in config/vehicles, or a YAML file.")]
Conditions: TypeAlias = Annotated[
    str, typer.Option(help="Wind, noise and delays: a name in config/conditions, or a YAML file.")
]
DnnGpModel: TypeAlias = Annotated[
    str, typer.Option(help="Network of dnn+gp: a name in config/models, or a file.")
]
FlightLogs: TypeAlias = Annotated[
    list[Path], typer.Argument(metavar="RECORDING...", help="Flight logs: .tlog, .tlog.xz, .ulg or .mcap.")
]
PageDirectory: TypeAlias = Annotated[
    Path | None, typer.Option(file_okay=False, help="Write a page with pictures into this directory.")
]


def after(asked: After | None, *, land: bool) -> After:
    """How the vehicle is handed back by `--after` and `--land`; InputError where they contradict."""
    if land and asked not in (None, After.LAND):
        raise InputError(f"--land and --after {asked} contradict each other: leave one out")
    return After.LAND if land else asked or After.HOLD


def placement(
    size: float, plane: Plane, origin: tuple[float, float], heading: float, altitude: float, flip_y: bool
) -> Placement:
    """The placement that the options describe; InputError where a value is out of range."""
    return Placement(
        size_m=size,
        plane=plane.value,
        origin=origin,
        heading_rad=math.radians(heading),
        altitude_m=altitude,
        flip_y=flip_y,
    )


def limits(speed: float | None) -> Limits:
    """The limits with that peak speed (m/s); InputError where it is not positive."""
    return Limits(speed_m_s=speed)


def network(model: str | None, online: OnlineSettings = DEFAULT) -> InverseNetwork | Library | None:
    """The network that `--model` names, if it names one; for `auto` all that fit the settings.

    Raises:
        InputError: no such model, or not one that fits this program.
    """
    if model == AUTO:
        return load_library(_MODELS, online.sample_time_s)
    return None if model is None else load_model(bundled.find("models", model, ".safetensors"))


def model_sha256(model: str | None) -> str | None:
    """The digest (hex) of the file that `--model` names, if it names one, for `auto` of all.

    Raises:
        InputError: as `network`.
    """
    if model is None:
        return None
    files = library_files(_MODELS) if model == AUTO else [bundled.find("models", model, ".safetensors")]
    return hashlib.sha256(b"".join(file.read_bytes() for file in files)).hexdigest()


def signing_key(file: Path | None) -> SigningKey | None:
    """The key that `--signing-key` names, if it names one; InputError where the file is not fit for one."""
    return None if file is None else read_signing_key(file)


def online_settings(preset: Preset, file: Path | None) -> OnlineSettings:
    """The preset's, but for what the file has that `--settings` names; InputError where one is wrong."""
    return preset.settings if file is None else read_settings(file, preset.settings, "config/online.yaml")


def guard_limits(file: Path | None) -> GuardLimits | None:
    """The limits in the file that `--guard` names, if it names one; InputError where one is wrong."""
    return None if file is None else read_guard_limits(file)


def writable(path: Path) -> Path:
    """`path`, whose folder now exists: to be known before a long job, not after it.

    Raises:
        InputError: nothing can be written there.
    """
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        is_new = not path.exists()
        path.open("ab").close()
        if is_new:
            path.unlink()
    except OSError as error:
        raise InputError(f"{path}: cannot be written: {error.strerror}") from error
    return path
