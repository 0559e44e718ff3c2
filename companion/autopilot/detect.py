"""Which autopilot is on the other end, and what flies it."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass

from companion.autopilot.ardupilot import ArduPilot
from companion.autopilot.interface import Autopilot
from companion.autopilot.px4 import Px4
from companion.errors import FlightError, NoReplyError
from companion.link.command import request_message
from companion.link.connection import Connection
from companion.link.dialect import mavlink
from companion.link.telemetry import Telemetry

_AUTOPILOTS: Mapping[int, Callable[[Connection, Telemetry], Autopilot]] = {
    mavlink.MAV_AUTOPILOT_PX4: Px4,
    mavlink.MAV_AUTOPILOT_ARDUPILOTMEGA: ArduPilot,
}
"""What flies which MAV_AUTOPILOT."""
MULTIROTORS = (
    mavlink.MAV_TYPE_QUADROTOR,
    mavlink.MAV_TYPE_HEXAROTOR,
    mavlink.MAV_TYPE_OCTOROTOR,
    mavlink.MAV_TYPE_TRICOPTER,
    mavlink.MAV_TYPE_DODECAROTOR,
    mavlink.MAV_TYPE_DECAROTOR,
    mavlink.MAV_TYPE_COAXIAL,
)
_NAMES = {mavlink.MAV_AUTOPILOT_PX4: "PX4", mavlink.MAV_AUTOPILOT_ARDUPILOTMEGA: "ArduPilot"}


@dataclass(frozen=True, slots=True)
class Identity:
    """What a vehicle says it is.

    Attributes:
        autopilot: name of the autopilot software.
        version: of the software, such as 1.16.0; None when it does not tell.
        takes_setpoints: whether it takes position setpoints; None when it does not tell.
        uid: of the flight controller, in hexadecimal; None when it does not tell.
    """

    autopilot: str
    version: str | None = None
    takes_setpoints: bool | None = None
    uid: str | None = None


async def identify(connection: Connection) -> Identity:
    """What the connection's vehicle is, from HEARTBEAT and AUTOPILOT_VERSION."""
    number = connection.heartbeat.autopilot
    name = _NAMES.get(number, f"autopilot {number}")
    try:
        told = await request_message(connection, mavlink.MAVLink_autopilot_version_message)
    except NoReplyError:
        return Identity(name)
    version = told.flight_sw_version
    return Identity(
        name,
        version=f"{version >> 24}.{version >> 16 & 0xFF}.{version >> 8 & 0xFF}",
        takes_setpoints=bool(
            told.capabilities & mavlink.MAV_PROTOCOL_CAPABILITY_SET_POSITION_TARGET_LOCAL_NED
        ),
        uid=_uid(told),
    )


async def detect(connection: Connection, telemetry: Telemetry) -> Autopilot:
    """The connection's vehicle, ready to be flown.

    Raises:
        FlightError: it is none that this program can fly.
    """
    identity = await identify(connection)
    make = _AUTOPILOTS.get(connection.heartbeat.autopilot)
    if make is None:
        raise FlightError(
            f"{identity.autopilot} vehicles cannot be flown: connect to one of {' or '.join(_NAMES.values())}"
        )
    if connection.heartbeat.type not in MULTIROTORS:  # modes of planes and rovers have other numbers
        raise FlightError(
            f"this {identity.autopilot} vehicle (MAV_TYPE {connection.heartbeat.type}) is no multirotor"
        )
    if identity.takes_setpoints is False:
        raise FlightError(f"this {identity.autopilot} takes no position setpoints: it needs another build")
    return make(connection, telemetry)


def _uid(told: mavlink.MAVLink_autopilot_version_message) -> str | None:
    long = bytes(told.uid2)
    if any(long):
        return long.rstrip(b"\0").hex()
    return f"{told.uid:x}" if told.uid else None
