"""What `fly` and `collect` share: one flight on one vehicle, shown as it happens and kept whatever comes."""

import math
from collections.abc import Callable, Sequence
from contextlib import nullcontext
from dataclasses import asdict, dataclass, replace
from functools import partial
from pathlib import Path
from typing import Protocol

import typer
from rich.console import Console

from companion import __version__, clock
from companion.autopilot import Autopilot, Identity, detect, identify
from companion.cli.display import FlightDisplay
from companion.cli.flown_similarity import source_of, tell_similarity
from companion.cli.recorded import ask_how_it_flies, configuration, link_text, recorded, versions
from companion.cli.thermometer import Thermometer
from companion.cli.unfinished import FlightNote
from companion.doctor.failsafe import failsafe_findings, require_safe
from companion.doctor.finding import Severity
from companion.errors import NoReplyError
from companion.flight.flight import FlightOutcome, FlightPlan, fly
from companion.flight.states import FlightState
from companion.flight.takeoff import Announce
from companion.flight.technique import Technique
from companion.learning.inverse_network import InverseNetwork
from companion.learning.library import Library
from companion.link import connect, parse_address, start_telemetry
from companion.link.address import Address, Simulated
from companion.link.connection import Connection
from companion.link.dialect import mavlink
from companion.link.exposure import warning
from companion.link.signing import SigningKey
from companion.link.status_text import status_text
from companion.link.telemetry import Telemetry
from companion.mission.vehicle_fence import vehicle_fence
from companion.priority import prioritised
from companion.recording import Provenance
from companion.recording.topics import CONFIGURATION, TECHNIQUE, VERSIONS
from companion.trajectory import Limits, Trajectory, summarise
from companion.trajectory.limits import peaks_of, stretches

STOPPED = 130
"""Exit status that shells report for a program which Ctrl-C ended."""


class Course(Protocol):
    """What to fly, before it is known which vehicle will."""

    @property
    def name(self) -> str:
        """What to call it."""
        ...

    def preview(self, limits: Limits) -> list[str]:
        """What would be flown without a vehicle to say more, in lines."""
        ...

    async def lay(
        self, connection: Connection, telemetry: Telemetry, limits: Limits, announce: Announce
    ) -> FlightPlan:
        """The flight for the vehicle that is connected, within `limits`, which are the vehicle's own as well.

        Raises:
            InputError: a fence or a limit forbids it.
        """
        ...


@dataclass(frozen=True, eq=False)
class Placed:
    """A trajectory that has its place, and depends on the vehicle only by its limits.

    Attributes:
        plan: with the trajectory within the limits of the user.
        trajectory_within: makes it anew for the vehicle's own limits.
    """

    plan: FlightPlan
    trajectory_within: Callable[[Limits], Trajectory]

    @property
    def name(self) -> str:
        """The trajectory's own."""
        return self.plan.trajectory.name

    def preview(self, limits: Limits) -> list[str]:
        """The trajectory in a few numbers."""
        return summarise(self.plan.trajectory, limits).lines()

    async def lay(
        self, connection: Connection, telemetry: Telemetry, limits: Limits, announce: Announce
    ) -> FlightPlan:
        """The plan with the trajectory within `limits`; says where that takes longer."""
        trajectory = self.trajectory_within(limits)
        own = await vehicle_fence(connection, telemetry, announce)
        own.require_inside(trajectory)
        usual_s = self.plan.trajectory.duration_s
        if trajectory.duration_s > usual_s:
            asked = stretches(peaks_of(self.plan.trajectory), limits.peaks(usual_speed_m_s=math.inf))
            beyond = ", ".join(name for name, stretch in asked.items() if stretch > 1.0)
            announce(
                f"this vehicle gives less than the trajectory asks for ({beyond}): it takes "
                f"{trajectory.duration_s:.1f} s instead of {usual_s:.1f} s"
            )
        for line in summarise(trajectory, limits).lines():
            announce(line)
        altitude_m = own.bounds.altitude_within(self.plan.takeoff_altitude_m)
        return replace(self.plan, trajectory=trajectory, vehicle_fence=own, takeoff_altitude_m=altitude_m)


@dataclass(frozen=True, eq=False)
class Request:
    """A flight that is asked for.

    Attributes:
        address: where the vehicle is.
        system_id: of the vehicle; None for the first that is heard.
        limits: what the user allows.
        course: what to fly.
        provenance: what the recording belongs to.
        technique: how it is flown.
        signing: the key of a signed link.
        forward: where ground stations share the link.
        accept_failsafe: fly although the autopilot's failsafe is unsafe.
        notes: folder for the note of a flight under way; None for none.
        network: what u1 is made with: a network, or a library that one is taken from.
    """

    address: Address
    system_id: int | None
    limits: Limits
    course: Course
    provenance: Provenance
    technique: Technique
    signing: SigningKey | None = None
    forward: Sequence[str] = ()
    accept_failsafe: bool = False
    notes: Path | None = None
    network: InverseNetwork | Library | None = None


@dataclass(frozen=True, eq=False)
class Flown:
    """A flight that came to its end.

    Attributes:
        outcome: what came of it.
        system_id: MAVLink id of the vehicle.
        identity: its autopilot.
        recording: the MCAP file that was written, if any.
    """

    outcome: FlightOutcome
    system_id: int
    identity: Identity
    recording: Path | None


def vehicle_name(address: Address) -> str:
    """What to call the vehicle at `address` where nobody gave it a name."""
    return Path(address.vehicle).stem if isinstance(address, Simulated) else "unnamed"


def provenance(address: Address, vehicle: str, trajectory: str, strategy: str) -> Provenance:
    """What the recording of a flight belongs to."""
    flight = Provenance(vehicle=vehicle, trajectory=trajectory, strategy=strategy, software=__version__)
    if isinstance(address, Simulated):
        return flight.model_copy(update={"conditions": address.conditions, "seed": address.seed})
    return flight


def conduct(request: Request, record: Path | None, console: Console) -> Flown:
    """Fly: in virtual time on the built-in vehicle, in real time on any other.

    Args:
        request: what to fly, and where.
        record: file for the recording, which is written while it is flown; None for none.
        console: where the flight is shown.

    Raises:
        ImpromptuError: as `connect` and `fly`.
        typer.Exit: Ctrl-C ended the flight.
    """
    virtual = isinstance(request.address, Simulated)
    try:
        with nullcontext() if virtual else prioritised():
            return clock.run(_fly(request, record, console), virtual=virtual)
    except KeyboardInterrupt:
        console.print("stopped")
        raise typer.Exit(STOPPED) from None


async def _fly(request: Request, record: Path | None, console: Console) -> Flown:
    with FlightDisplay(console) as display:
        listening = [request.address, *map(parse_address, request.forward)]
        if told := warning(listening, signed=request.signing is not None):
            display.phase(told)
        display.phase("connecting")
        async with (
            connect(
                request.address,
                system_id=request.system_id,
                signing=request.signing,
                forward=request.forward,
            ) as connection,
            recorded(connection, record, request.provenance, display.phase) as (recorder, file),
        ):
            connection.presence.subscribe(lambda change: display.phase(link_text(change)))
            connection.status_texts.subscribe(display.vehicle_said)
            telemetry = await start_telemetry(connection)
            thermometer = Thermometer()
            if not isinstance(request.address, Simulated):
                connection.spawn(thermometer.keep_reading())
            identity = await identify(connection)
            firmware = "" if identity.version is None else f" {identity.version}"
            display.phase(f"connected to system {connection.system_id}, {identity.autopilot}{firmware}")
            recorder.metadata(VERSIONS, versions(identity))
            recorder.metadata(TECHNIQUE, request.technique.model_dump(mode="json"))
            await _look_at_failsafe(connection, identity, request.accept_failsafe, display.phase)
            await ask_how_it_flies(connection, identity, recorder)
            autopilot = await detect(connection, telemetry)
            limits = await _limits(request.limits, autopilot, display.phase)
            plan = await request.course.lay(connection, telemetry, limits, display.phase)
            recorder.metadata(CONFIGURATION, configuration(plan, limits))
            note = _note(request, connection.system_id)
            outcome = await fly(
                plan if note is None else replace(plan, cut_off=note.former()),
                autopilot,
                telemetry,
                provenance=request.provenance,
                recorder=recorder,
                announce=partial(_tell, connection, display.phase),
                progress=display.progress,
                on_state=partial(_tell_state, connection, note),
                temperature_c=lambda: thermometer.celsius,
            )
            source = source_of(request.network, plan.supervision)
            if source is not None:
                await tell_similarity(source, recorder, display.phase)
            return Flown(outcome, connection.system_id, identity, file)


async def _look_at_failsafe(
    connection: Connection, identity: Identity, accepted: bool, announce: Announce
) -> None:
    """Tell what is wrong with what the autopilot does without setpoints; FlightError where it is unsafe."""
    findings = await failsafe_findings(connection, identity)
    if not accepted:
        require_safe(findings)
    for finding in findings:
        if finding.severity is not Severity.FINE:
            announce(f"{finding.topic}: {finding.seen}: {finding.advice}")


def _note(request: Request, system_id: int) -> FlightNote | None:
    """The note of flights of a vehicle that outlives this process."""
    if request.notes is None or isinstance(request.address, Simulated):
        return None
    return FlightNote(request.notes, system_id, request.course.name)


def _tell_state(connection: Connection, note: FlightNote | None, state: FlightState) -> None:
    """Note what the flight came to, and say it to everyone on the link."""
    if note is not None:
        note.state(state)
    worse = state in (FlightState.YIELDED, FlightState.FAILED)
    severity = mavlink.MAV_SEVERITY_WARNING if worse else mavlink.MAV_SEVERITY_INFO
    _say(connection, severity, str(state))


def _tell(connection: Connection, show: Announce, text: str) -> None:
    """What happens in flight, for the user and for everyone on the link."""
    show(text)
    _say(connection, mavlink.MAV_SEVERITY_NOTICE, text)


def _say(connection: Connection, severity: int, text: str) -> None:
    for message in status_text(severity, f"companion: {text}"):
        connection.send(message)


async def _limits(limits: Limits, autopilot: Autopilot, announce: Announce) -> Limits:
    """The limits with the vehicle's own, where it tells them."""
    try:
        own = await autopilot.motion_limits()
    except NoReplyError:
        up_m_s, down_m_s = limits.up_m_s, limits.down_m_s
        announce(f"it tells no vertical speed limits: {up_m_s:g} m/s up, {down_m_s:g} m/s down assumed")
        return limits
    return limits.within_vehicle(**asdict(own))
