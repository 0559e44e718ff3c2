"""The recording of a flight on a link: where it is kept, and what is in it besides the flight itself."""

import asyncio
import platform
import re
import shlex
import sys
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager, suppress
from importlib.metadata import version
from pathlib import Path
from typing import Any

from pydantic_core import to_jsonable_python

from companion import clock
from companion.autopilot import Identity
from companion.autopilot.flown_parameters import FLOWN_BY
from companion.flight.plan import FlightPlan
from companion.flight.recorder import FlightRecorder, Recorder
from companion.flight.takeoff import Announce
from companion.link.address import Address, Simulated
from companion.link.connection import Connection
from companion.link.dialect import mavlink
from companion.link.parameter import read_parameters
from companion.link.parameter_encoding import ParameterType, decode_value, usual_encoding
from companion.link.presence import LinkChange
from companion.link.status_text import StatusText
from companion.recording import Provenance
from companion.recording.flight_log import flight_log
from companion.recording.topics import Level
from companion.trajectory import Limits

_PARAMETERS_WITHIN_S = 2.0
_ATTEMPTS = 2
_LIBRARIES = ("impromptu", "numpy", "scipy", "pymavlink")


def usual_path(address: Address, folder: Path, name: str) -> Path | None:
    """Where a flight is recorded that was not told where; None for the built-in vehicle's, in a virtual time.

    Args:
        address: of the vehicle.
        folder: of all recordings.
        name: of the flight.
    """
    if isinstance(address, Simulated):
        return None
    return folder / f"{clock.utc_stamp()}-{re.sub(r'[^A-Za-z0-9_.+]+', '-', name)}.mcap"


@asynccontextmanager
async def recorded(
    connection: Connection, path: Path | None, provenance: Provenance, announce: Announce
) -> AsyncIterator[tuple[Recorder, Path | None]]:
    """Record a flight until the block ends: to `path` and the `.tlog` beside it, or in memory.

    Gives the recorder, and the path of the MCAP file, which differs where another flight is writing to it.

    Args:
        connection: to the vehicle; what it says and whether it is there is recorded, too.
        path: of the MCAP file; None for the memory.
        provenance: what the flight is.
        announce: told where the recording is, and what keeps it from being written.

    Raises:
        InputError: a file cannot be opened.
    """
    if path is None:
        recorder: Recorder = FlightRecorder()
        _record_link(connection, recorder)
        yield recorder, None
        return

    def tell(text: str) -> None:
        announce(text)
        recorder.event(clock.now(), text, "recording", level=Level.WARNING)

    async with flight_log(path, provenance, tell) as log:
        recorder = Recorder(log, log.epoch_s)
        _record_link(connection, recorder)
        unhear = connection.overhear(log.frame)
        try:
            yield recorder, log.path
        finally:
            unhear()
            announce(f"recording: {log.path}")


def versions(identity: Identity) -> dict[str, str]:
    """What the numbers of a flight may depend on, by name."""
    return {
        **{library: version(library) for library in _LIBRARIES},
        "python": platform.python_version(),
        "machine": platform.machine(),
        "autopilot": identity.autopilot,
        "firmware": identity.version or "unknown",
    }


def configuration(plan: FlightPlan, limits: Limits) -> dict[str, Any]:
    """How a flight was asked for, and what came of that on this vehicle, as JSON can say it.

    Args:
        plan: as it is flown.
        limits: what was allowed and what the vehicle allows, together.
    """
    chosen = {
        "command": shlex.join(["companion", *sys.argv[1:]]),
        "limits": limits,
        "guard": plan.limits,
        "vehicle_fence": plan.vehicle_fence,
        "period_s": plan.period_s,
        "takeoff_altitude_m": plan.takeoff_altitude_m,
        "settle_s": plan.settle_s,
        "yaw": plan.yaw,
        "after": plan.after,
        "resume": plan.resume,
    }
    told: dict[str, Any] = to_jsonable_python(chosen, inf_nan_mode="null")
    return told


async def ask_how_it_flies(connection: Connection, identity: Identity, recorder: Recorder) -> None:
    """Have the vehicle tell its gains, limits, failsafes and fence; all that it tells is recorded.

    An event names those that it did not tell; a slow link holds a flight up for two seconds at most.
    """
    names = FLOWN_BY.get(identity.autopilot, ())
    told: set[str] = set()
    unsubscribe = connection.subscribe(
        mavlink.MAVLink_param_value_message, lambda message: told.add(message.param_id)
    )
    encoding = usual_encoding(connection.heartbeat.autopilot)
    try:
        with suppress(TimeoutError):
            async with asyncio.timeout(_PARAMETERS_WITHIN_S):
                await read_parameters(connection, names, encoding, attempts=_ATTEMPTS)
    finally:
        unsubscribe()
    untold = [name for name in names if name not in told]
    if untold:
        recorder.event(
            clock.now(), f"parameters that the vehicle did not tell: {', '.join(untold)}", "parameters"
        )


def link_text(change: LinkChange) -> str:
    """In words, that the vehicle was lost or is back."""
    return "lost the vehicle" if change.lost else f"the vehicle is back after {change.silence_s:.1f} s"


def _record_link(connection: Connection, recorder: Recorder) -> None:
    encoding = usual_encoding(connection.heartbeat.autopilot)

    def parameter(message: mavlink.MAVLink_param_value_message) -> None:
        try:
            value = decode_value(message.param_value, ParameterType(message.param_type), encoding)
        except ValueError:
            return  # of a type that is wider than the field
        recorder.parameter(clock.now(), message.param_id, value)

    def status_text(line: StatusText) -> None:
        told = {"severity": line.severity}
        recorder.event(line.received_s, f"vehicle: {line.text}", "vehicle", told, level_of(line.severity))

    def link(change: LinkChange) -> None:
        level = Level.WARNING if change.lost else Level.INFO
        recorder.event(change.time_s, link_text(change), "link", level=level)

    connection.subscribe(mavlink.MAVLink_param_value_message, parameter)
    connection.status_texts.subscribe(status_text)
    connection.presence.subscribe(link)


def level_of(severity: int) -> Level:
    """Of a MAV_SEVERITY, in which less is graver."""
    if severity <= mavlink.MAV_SEVERITY_ERROR:
        return Level.ERROR
    return Level.WARNING if severity == mavlink.MAV_SEVERITY_WARNING else Level.INFO
