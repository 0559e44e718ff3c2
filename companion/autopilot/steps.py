"""Steps of a flight that every autopilot takes alike: arm, climb, come down."""

from collections.abc import Callable

from companion import clock
from companion.arrays import Vec3
from companion.autopilot.flight_modes import MODE_TIMEOUT_S, FlightModes
from companion.errors import FlightError, NoReplyError
from companion.link.command import command
from companion.link.connection import Connection
from companion.link.dialect import mavlink
from companion.link.parameter import read_parameter
from companion.link.telemetry import Telemetry

_CLIMB_M_S = 0.5  # slower than any sensible MPC_TKO_SPEED or WPNAV_SPEED_UP
_TAKEOFF_MARGIN_S = 10.0  # motors spin up, heartbeat
_TAKEOFF_TOLERANCE_M = 0.3
_LAND_TIMEOUT_S = 180.0
_RETURN_TIMEOUT_S = 600.0


async def arm(connection: Connection, telemetry: Telemetry, modes: FlightModes) -> None:
    """Arm the vehicle, unless it is armed; raises as `command` and `FlightModes.until`."""
    if not telemetry.status.armed:
        await command(connection, mavlink.MAV_CMD_COMPONENT_ARM_DISARM, 1.0)
        await modes.until(lambda: telemetry.status.armed, MODE_TIMEOUT_S, "it did not arm")


async def until_climbed(
    start: Vec3,
    altitude_m: float,
    telemetry: Telemetry,
    modes: FlightModes,
    own: tuple[int, ...],
    finished: Callable[[], bool] = lambda: False,
) -> None:
    """Wait until the vehicle is `altitude_m` (m) above `start` (NED, m), or its takeoff is `finished`.

    Raises:
        TakenError: it left the modes of a takeoff, `own`, unasked.
        FlightError: it disarmed; and as `FlightModes.until`, as LinkError.
    """
    enough_m = altitude_m - _TAKEOFF_TOLERANCE_M

    was_armed = telemetry.status.armed

    def is_there() -> bool:
        if was_armed and not telemetry.status.armed:
            raise FlightError("the vehicle disarmed in its takeoff: see what it says, and its log")
        state = telemetry.state
        return finished() or (state is not None and start[2] - state.position[2] >= enough_m)

    timeout_s = altitude_m / _CLIMB_M_S + _TAKEOFF_MARGIN_S
    await modes.until(modes.unless_taken(own, is_there), timeout_s, f"it did not climb to {altitude_m:g} m")


async def return_home(
    connection: Connection, telemetry: Telemetry, modes: FlightModes, own: tuple[int, ...]
) -> None:
    """Have the vehicle return in its own way, and wait until it is down; raises as `until_down`."""
    await command(connection, mavlink.MAV_CMD_NAV_RETURN_TO_LAUNCH)
    await until_down(telemetry, modes, own, _RETURN_TIMEOUT_S)


async def parameter_or(connection: Connection, name: str, otherwise: float) -> float:
    """The value of a parameter; `otherwise`, which is its default, from a vehicle that does not tell."""
    try:
        return await read_parameter(connection, name)
    except NoReplyError:
        return otherwise


async def until_down(
    telemetry: Telemetry, modes: FlightModes, own: tuple[int, ...], timeout_s: float = _LAND_TIMEOUT_S
) -> None:
    """Wait until the vehicle is on the ground, and disarmed itself if it does that at all.

    Raises:
        TakenError: it left the modes of a landing, `own`, unasked.
        FlightError, LinkError: as `FlightModes.until`.
    """
    is_down = modes.unless_taken(own, lambda: telemetry.status.is_down(clock.now()))
    await modes.until(is_down, timeout_s, "it did not land and disarm")
