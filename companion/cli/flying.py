"""What `fly` and `collect` share: one flight on one vehicle, shown as it happens and kept whatever comes."""

from collections.abc import Callable
from dataclasses import asdict, dataclass, replace
from pathlib import Path

import typer
from rich.console import Console

from companion import __version__, clock
from companion.autopilot import Autopilot, Identity, detect, identify
from companion.cli.display import FlightDisplay
from companion.errors import NoReplyError
from companion.flight.flight import FlightOutcome, FlightPlan, fly
from companion.flight.recorder import FlightRecorder
from companion.link import connect, start_telemetry
from companion.link.address import Address, Simulated
from companion.recording import Provenance, write_recording
from companion.trajectory import Limits, Trajectory

_STOPPED = 130  # what shells report for a program that Ctrl-C ended


@dataclass(frozen=True, eq=False)
class Request:
    """A flight that is asked for.

    Attributes:
        address: where the vehicle is.
        system_id: of the vehicle; None for the first that is heard.
        plan: what to fly.
        limits: those that its trajectory was made within.
        trajectory_within: makes the trajectory anew for the vehicle's own limits.
        provenance: what the recording belongs to.
    """

    address: Address
    system_id: int | None
    plan: FlightPlan
    limits: Limits
    trajectory_within: Callable[[Limits], Trajectory]
    provenance: Provenance


@dataclass(frozen=True, eq=False)
class Flown:
    """A flight that came to its end.

    Attributes:
        outcome: what came of it.
        system_id: MAVLink id of the vehicle.
        identity: its autopilot.
    """

    outcome: FlightOutcome
    system_id: int
    identity: Identity


def vehicle_name(address: Address) -> str:
    """What to call the vehicle at `address` where nobody gave it a name."""
    return Path(address.vehicle).stem if isinstance(address, Simulated) else "unnamed"


def provenance(address: Address, vehicle: str, trajectory: str, strategy: str) -> Provenance:
    """What the recording of a flight belongs to."""
    flight = Provenance(vehicle=vehicle, trajectory=trajectory, strategy=strategy, software=__version__)
    if isinstance(address, Simulated):
        return flight.model_copy(update={"conditions": address.conditions, "seed": address.seed})
    return flight


def show(console: Console, *lines: str) -> None:
    """Print lines as they are."""
    for line in lines:
        console.print(line, markup=False, highlight=False, soft_wrap=True)


def conduct(request: Request, record: Path | None, console: Console) -> Flown:
    """Fly: in virtual time on the built-in vehicle, in real time on any other.

    Args:
        request: what to fly, and where.
        record: file for the recording; that of a flight which failed is written too.
        console: where the flight is shown.

    Raises:
        ImpromptuError: as `connect` and `fly`.
        typer.Exit: Ctrl-C ended the flight.
    """
    recorder = FlightRecorder()
    try:
        return clock.run(_fly(request, recorder, console), virtual=isinstance(request.address, Simulated))
    except KeyboardInterrupt:
        console.print("stopped")
        raise typer.Exit(_STOPPED) from None
    finally:
        recording = recorder.recording(request.provenance)
        if record is not None and len(recording.states.time_s):
            write_recording(recording, record)
            show(console, f"recording: {record}")


async def _fly(request: Request, recorder: FlightRecorder, console: Console) -> Flown:
    with FlightDisplay(console) as display:
        display.phase("connecting")
        async with connect(request.address, system_id=request.system_id) as connection:
            connection.status_texts.subscribe(display.vehicle_said)
            connection.status_texts.subscribe(
                lambda line: recorder.event(line.received_s, f"vehicle: {line.text}")
            )
            telemetry = await start_telemetry(connection)
            identity = await identify(connection)
            version = "" if identity.version is None else f" {identity.version}"
            display.phase(f"connected to system {connection.system_id}, {identity.autopilot}{version}")
            autopilot = await detect(connection, telemetry)
            outcome = await fly(
                replace(request.plan, trajectory=await _trajectory(request, autopilot, display)),
                autopilot,
                telemetry,
                provenance=request.provenance,
                recorder=recorder,
                announce=display.phase,
                progress=display.progress,
            )
            return Flown(outcome, connection.system_id, identity)


async def _trajectory(request: Request, autopilot: Autopilot, display: FlightDisplay) -> Trajectory:
    """The trajectory within the vehicle's own limits, where it tells them."""
    try:
        own = await autopilot.motion_limits()
    except NoReplyError:
        up_m_s, down_m_s = request.limits.up_m_s, request.limits.down_m_s
        display.phase(f"it tells no vertical speed limits: {up_m_s:g} m/s up, {down_m_s:g} m/s down assumed")
        return request.plan.trajectory
    limits = request.limits.within_vehicle(**asdict(own))
    return request.plan.trajectory if limits == request.limits else request.trajectory_within(limits)
