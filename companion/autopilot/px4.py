"""PX4: offboard control as https://docs.px4.io/main/en/flight_modes/offboard.html has it."""

import asyncio
import math
from collections.abc import Callable, Sequence
from enum import Enum

from companion import clock
from companion.arrays import Vec3
from companion.autopilot.setpoint import position_target
from companion.errors import FlightError, LinkError, RefusedError, TakenError
from companion.link.command import command
from companion.link.connection import Connection
from companion.link.dialect import mavlink
from companion.link.parameter import read_parameter
from companion.link.status import Landed
from companion.link.telemetry import Telemetry

_MODE_TIMEOUT_S = 3.0  # a change of mode shows in the next HEARTBEAT, which comes once a second
_CLIMB_M_S = 0.5  # slower than any sensible MPC_TKO_SPEED
_TAKEOFF_MARGIN_S = 10.0  # motors spin up (COM_SPOOLUP_TIME, MPC_TKO_RAMP_T), heartbeat
_TAKEOFF_TOLERANCE_M = 0.3
_LAND_TIMEOUT_S = 180.0
_STREAM_FIRST_S = 0.2  # for the stream's first setpoints to arrive: PX4 refuses OFFBOARD without them
_ENGAGE_ATTEMPTS = 3
_POLL_S = 0.02
_NAN = math.nan


class _Mode(Enum):
    """Main and sub mode of the modes that PX4 is sent to (px4_custom_mode.h)."""

    TAKEOFF = (4, 2)
    HOLD = (4, 3)
    LAND = (4, 6)
    OFFBOARD = (6, 0)


_MODE_NAMES = {
    (1, 0): "MANUAL",
    (2, 0): "ALTCTL",
    (3, 0): "POSCTL",
    (4, 1): "AUTO.READY",
    (4, 2): "AUTO.TAKEOFF",
    (4, 3): "AUTO.LOITER",
    (4, 4): "AUTO.MISSION",
    (4, 5): "AUTO.RTL",
    (4, 6): "AUTO.LAND",
    (5, 0): "ACRO",
    (6, 0): "OFFBOARD",
    (7, 0): "STABILIZED",
}


def mode_name(custom_mode: int) -> str:
    """The name of the flight mode in HEARTBEAT.custom_mode."""
    main_and_sub = _main_and_sub(custom_mode)
    return _MODE_NAMES.get(main_and_sub, "mode {}.{}".format(*main_and_sub))


class Px4:
    """A vehicle that PX4 flies, as an `Autopilot`."""

    def __init__(self, connection: Connection, telemetry: Telemetry) -> None:
        self._connection = connection
        self._telemetry = telemetry
        self._engaged = False
        self._taken = asyncio.Event()
        self._taken_by = ""
        connection.subscribe(mavlink.MAVLink_heartbeat_message, self._watch_mode)

    @property
    def mode(self) -> str:
        """The flight mode, by PX4's own name."""
        return mode_name(self._telemetry.status.custom_mode)

    @property
    def engaged(self) -> bool:
        """Whether the vehicle is in OFFBOARD because we asked for it."""
        return self._engaged

    async def fastest_climb_and_descent(self) -> tuple[float, float]:
        """The vehicle's own vertical speed limits (m/s): MPC_Z_VEL_MAX_UP, MPC_Z_VEL_MAX_DN."""
        return (
            await read_parameter(self._connection, "MPC_Z_VEL_MAX_UP"),
            await read_parameter(self._connection, "MPC_Z_VEL_MAX_DN"),
        )

    async def arm(self) -> None:
        """Arm, unless it is armed."""
        if not self._telemetry.status.armed:
            await command(self._connection, mavlink.MAV_CMD_COMPONENT_ARM_DISARM, 1.0)
            await self._until(lambda: self._telemetry.status.armed, _MODE_TIMEOUT_S, "it did not arm")

    async def takeoff(self, altitude_m: float) -> None:
        """Climb to `altitude_m` above where it is; returns when it is there."""
        start = self._telemetry.state or await self._telemetry.next_state()
        place = await self._connection.receive(mavlink.MAVLink_global_position_int_message, timeout_s=2.0)
        above_sea_m = place.alt * 1e-3 + altitude_m
        await command(
            self._connection, mavlink.MAV_CMD_NAV_TAKEOFF, _NAN, 0.0, 0.0, _NAN, _NAN, _NAN, above_sea_m
        )
        enough_m = altitude_m - _TAKEOFF_TOLERANCE_M

        def is_there() -> bool:
            state = self._telemetry.state
            return state is not None and start.position[2] - state.position[2] >= enough_m

        timeout_s = altitude_m / _CLIMB_M_S + _TAKEOFF_MARGIN_S
        is_there_or_taken = self._unless_taken((_Mode.TAKEOFF, _Mode.HOLD), is_there)
        await self._until(is_there_or_taken, timeout_s, f"it did not climb to {altitude_m:g} m")

    async def engage(self) -> None:
        """Switch to OFFBOARD, once the setpoints stream."""
        await asyncio.sleep(_STREAM_FIRST_S)
        for attempt in range(_ENGAGE_ATTEMPTS):
            try:
                await self._switch_to(_Mode.OFFBOARD)
                break
            except RefusedError:
                if attempt == _ENGAGE_ATTEMPTS - 1:
                    raise
        self._taken.clear()
        self._engaged = True

    async def hold(self) -> None:
        """Switch to AUTO.LOITER."""
        self._engaged = False
        await self._switch_to(_Mode.HOLD)

    async def land(self) -> None:
        """Land here; returns when the vehicle is on the ground and disarmed itself."""
        self._engaged = False
        await command(self._connection, mavlink.MAV_CMD_NAV_LAND, 0.0, 0.0, 0.0, _NAN, _NAN, _NAN, 0.0)
        is_down_or_taken = self._unless_taken((_Mode.LAND,), self._is_down)
        await self._until(is_down_or_taken, _LAND_TIMEOUT_S, "it did not land and disarm")

    async def until_taken(self) -> str:
        """Wait until the vehicle leaves OFFBOARD unasked; the name of the mode that it went to."""
        await self._taken.wait()
        return self._taken_by

    def send_setpoint(
        self,
        position: Vec3 | None,
        velocity: Vec3 | None = None,
        acceleration: Vec3 | None = None,
        yaw: float | None = None,
    ) -> None:
        """Send one setpoint, now; what is None PX4 leaves free."""
        target = self._connection.target
        self._connection.send(position_target(target, clock.now(), position, velocity, acceleration, yaw))

    async def _switch_to(self, mode: _Mode) -> None:
        flags = mavlink.MAV_MODE_FLAG_CUSTOM_MODE_ENABLED
        await command(self._connection, mavlink.MAV_CMD_DO_SET_MODE, flags, *mode.value)
        await self._until(lambda: self._is_in(mode), _MODE_TIMEOUT_S, f"it did not go to {mode.name}")

    def _is_in(self, mode: _Mode) -> bool:
        return _main_and_sub(self._telemetry.status.custom_mode) == mode.value

    def _is_down(self) -> bool:
        status = self._telemetry.status
        return status.landed is Landed.ON_GROUND and not status.armed

    def _unless_taken(self, modes: Sequence[_Mode], condition: Callable[[], bool]) -> Callable[[], bool]:
        """`condition`, but for a TakenError once the vehicle was in the first of `modes` and is in none."""
        begun = False

        def checked() -> bool:
            nonlocal begun
            begun = begun or self._is_in(modes[0])
            if condition():
                return True
            if begun and self._telemetry.status.armed and not any(map(self._is_in, modes)):
                raise TakenError(f"the vehicle went to {self.mode} unasked: it was left to whoever did that")
            return False

        return checked

    async def _until(self, condition: Callable[[], bool], timeout_s: float, otherwise: str) -> None:
        """Wait until `condition` holds.

        Raises:
            FlightError: it did not within `timeout_s` (s).
            LinkError: the vehicle fell silent meanwhile.
        """
        give_up_s = clock.now() + timeout_s
        while not condition():
            if self._connection.lost:
                raise LinkError("the vehicle fell silent: check the link")
            if clock.now() >= give_up_s:
                raise FlightError(
                    f"the vehicle accepted, but {otherwise} within {timeout_s:g} s; mode {self.mode}"
                )
            await asyncio.sleep(_POLL_S)

    def _watch_mode(self, message: mavlink.MAVLink_heartbeat_message) -> None:
        if self._engaged and _main_and_sub(message.custom_mode) != _Mode.OFFBOARD.value:
            self._engaged = False
            self._taken_by = mode_name(message.custom_mode)
            self._taken.set()


def _main_and_sub(custom_mode: int) -> tuple[int, int]:
    return custom_mode >> 16 & 0xFF, custom_mode >> 24
