"""PX4: offboard control as https://docs.px4.io/main/en/flight_modes/offboard.html has it."""

import asyncio
import math

from companion import clock
from companion.arrays import Vec3
from companion.autopilot import steps
from companion.autopilot.flight_modes import FlightModes
from companion.autopilot.interface import MotionLimits
from companion.autopilot.setpoint import position_target
from companion.errors import RefusedError
from companion.link.command import command
from companion.link.connection import Connection
from companion.link.dialect import mavlink
from companion.link.parameter import read_parameter
from companion.link.telemetry import Telemetry

_STREAM_FIRST_S = 0.2  # for the stream's first setpoints to arrive: PX4 refuses OFFBOARD without them
_ENGAGE_ATTEMPTS = 3
_NAN = math.nan


def _custom_mode(main: int, sub: int) -> int:
    """HEARTBEAT.custom_mode of a main and a sub mode (px4_custom_mode.h)."""
    return main << 16 | sub << 24


_TAKEOFF, _HOLD, _LAND = _custom_mode(4, 2), _custom_mode(4, 3), _custom_mode(4, 6)
_OFFBOARD = _custom_mode(6, 0)
_MODE_NAMES = {
    _custom_mode(1, 0): "MANUAL",
    _custom_mode(2, 0): "ALTCTL",
    _custom_mode(3, 0): "POSCTL",
    _custom_mode(4, 1): "AUTO.READY",
    _TAKEOFF: "AUTO.TAKEOFF",
    _HOLD: "AUTO.LOITER",
    _custom_mode(4, 4): "AUTO.MISSION",
    _custom_mode(4, 5): "AUTO.RTL",
    _LAND: "AUTO.LAND",
    _custom_mode(5, 0): "ACRO",
    _OFFBOARD: "OFFBOARD",
    _custom_mode(7, 0): "STABILIZED",
}


def mode_name(custom_mode: int) -> str:
    """The name of the flight mode in HEARTBEAT.custom_mode."""
    main, sub = _main_and_sub(custom_mode)
    return _MODE_NAMES.get(_custom_mode(main, sub), f"mode {main}.{sub}")


class Px4:
    """A vehicle that PX4 flies, as an `Autopilot`."""

    def __init__(self, connection: Connection, telemetry: Telemetry) -> None:
        self._connection = connection
        self._telemetry = telemetry
        self._modes = FlightModes(connection, telemetry, mode_name, _OFFBOARD)

    @property
    def mode(self) -> str:
        """The flight mode, by PX4's own name."""
        return self._modes.now

    @property
    def engaged(self) -> bool:
        """Whether the vehicle is in OFFBOARD because we asked for it."""
        return self._modes.engaged

    async def motion_limits(self) -> MotionLimits:
        """MPC_Z_VEL_MAX_UP and MPC_Z_VEL_MAX_DN; OFFBOARD keeps to no acceleration but by the tilt."""
        return MotionLimits(
            up_m_s=await read_parameter(self._connection, "MPC_Z_VEL_MAX_UP"),
            down_m_s=await read_parameter(self._connection, "MPC_Z_VEL_MAX_DN"),
        )

    async def arm(self) -> None:
        """Arm, unless it is armed."""
        await steps.arm(self._connection, self._telemetry, self._modes)

    async def takeoff(self, altitude_m: float) -> None:
        """Climb to `altitude_m` above where it is; returns when it is there."""
        start = self._telemetry.state or await self._telemetry.next_state()
        place = await self._connection.receive(mavlink.MAVLink_global_position_int_message, timeout_s=2.0)
        above_sea_m = place.alt * 1e-3 + altitude_m
        await command(
            self._connection, mavlink.MAV_CMD_NAV_TAKEOFF, _NAN, 0.0, 0.0, _NAN, _NAN, _NAN, above_sea_m
        )
        own = (_TAKEOFF, _HOLD)
        await steps.until_climbed(start.position, altitude_m, self._telemetry, self._modes, own)

    async def engage(self) -> None:
        """Switch to OFFBOARD, once the setpoints stream."""
        await asyncio.sleep(_STREAM_FIRST_S)
        for attempt in range(_ENGAGE_ATTEMPTS):
            try:
                await self._switch_to(_OFFBOARD)
                break
            except RefusedError:
                if attempt == _ENGAGE_ATTEMPTS - 1:
                    raise
        self._modes.engage()

    async def hold(self) -> None:
        """Switch to AUTO.LOITER."""
        self._modes.release()
        await self._switch_to(_HOLD)

    async def land(self) -> None:
        """Land here; returns when the vehicle is on the ground and disarmed itself."""
        self._modes.release()
        await command(self._connection, mavlink.MAV_CMD_NAV_LAND, 0.0, 0.0, 0.0, _NAN, _NAN, _NAN, 0.0)
        await steps.until_down(self._telemetry, self._modes, (_LAND,))

    async def until_taken(self) -> str:
        """Wait until the vehicle leaves OFFBOARD unasked; the name of the mode that it went to."""
        return await self._modes.until_taken()

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

    async def _switch_to(self, mode: int) -> None:
        await self._modes.switch(mode, *_main_and_sub(mode))


def _main_and_sub(custom_mode: int) -> tuple[int, int]:
    return custom_mode >> 16 & 0xFF, custom_mode >> 24
