"""What an autopilot does when setpoints stop, asked before a flight: the dead man's switch.

Nothing repeats a setpoint here. When the companion stalls or dies, its stream ends, and what happens then
is up to the autopilot's parameters.
"""

from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import replace

from companion.autopilot import Identity
from companion.doctor.checks import RULES
from companion.doctor.finding import Finding, Severity, warns
from companion.doctor.health import receives_remote_control
from companion.doctor.observation import Health, Observation
from companion.errors import FlightError, NoReplyError
from companion.link.command import request_message
from companion.link.connection import Connection
from companion.link.dialect import mavlink
from companion.link.parameter import read_parameters
from companion.link.parameter_encoding import Number, usual_encoding

_ASKED: Mapping[str, Sequence[str]] = {
    "PX4": ("COM_OF_LOSS_T", "COM_OBL_RC_ACT"),
    "ArduPilot": ("GUID_TIMEOUT",),
}
_ATTEMPTS = 3


async def failsafe_findings(connection: Connection, identity: Identity) -> list[Finding]:
    """What the parameters of the failsafe mean for a flight; where they are told, each with its value."""
    names = _ASKED.get(identity.autopilot, ())
    encoding = usual_encoding(connection.heartbeat.autopilot)
    told = await read_parameters(connection, names, encoding, attempts=_ATTEMPTS)
    values = {name: parameter.value for name, parameter in told.items()}
    silent = [
        warns(
            name, "the vehicle does not tell it: what it does when setpoints stop is not known", "look it up"
        )
        for name in names
        if name not in values
    ]
    remote = await _receives_remote_control(connection) if values else False
    return silent + judge_failsafe(identity, values, has_remote_control=remote)


def judge_failsafe(
    identity: Identity, values: Mapping[str, Number], *, has_remote_control: bool
) -> list[Finding]:
    """What the doctor's rules say of these values."""
    seen = Observation(
        system_id=0,
        identity=identity,
        vehicle_type="",
        is_multirotor=True,
        mode="",
        armed=False,
        seconds=0.0,
        health=Health(has_remote_control=has_remote_control),
        parameters=values,
    )
    rules = RULES[identity.autopilot] if values else {}
    return [
        replace(rules[name](name, value, seen), topic=f"{name} is {value:g}")
        for name, value in values.items()
    ]


def require_safe(findings: Sequence[Finding]) -> None:
    """Refuse to fly a vehicle whose failsafe is none.

    Raises:
        FlightError: names the parameter and its value, and says what to set.
    """
    for finding in findings:
        if finding.severity is Severity.STOPS:
            raise FlightError(
                f"{finding.topic}: {finding.seen}. First {finding.advice}; or fly all the same with "
                "--accept-failsafe"
            )


async def _receives_remote_control(connection: Connection) -> bool:
    with suppress(NoReplyError):
        return receives_remote_control(
            await request_message(connection, mavlink.MAVLink_sys_status_message, attempts=2)
        )
    return False
