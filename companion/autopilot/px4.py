"""PX4: offboard control as https://docs.px4.io/main/en/flight_modes/offboard.html has it."""

import asyncio
import math
from typing import ClassVar

from companion import clock
from companion.arrays import Vec3
from companion.autopilot import steps
from companion.autopilot.flight_modes import HOLD_ATTEMPTS, FlightModes
from companion.autopilot.interface import MotionLimits
from companion.autopilot.position_loop import PositionLoop, loop_of, read_position_loop
from companion.autopilot.setpoint import position_target
from companion.errors import RefusedError, TakenError
from companion.link.command import command, request_message
from companion.link.connection import Connection
from companion.link.dialect import mavlink
from companion.link.parameter import read_parameter
from companion.link.status import Landed
from companion.link.telemetry import Telemetry
from companion.state import VehicleState

_STREAM_FIRST_S = 0.2  # for the stream's first setpoints to arrive: PX4 refuses OFFBOARD without them
_ENGAGE_ATTEMPTS = 3
_LOSS_TIMEOUT_S = 1.0
_ALTITUDE_RADIUS_M = 0.8
"""Default of NAV_MC_ALT_RAD: so far below its altitude PX4 takes a takeoff for finished, and holds."""
_TOLERANCE_M = 0.3
_NAN = math.nan

_LOOP_GAINS = ("MPC_XY_P", "MPC_Z_P", "MPC_XY_VEL_P_ACC", "MPC_Z_VEL_P_ACC")


def _custom_mode(main: int, sub: int) -> int:
    """HEARTBEAT.custom_mode of a main and a sub mode (px4_custom_mode.h)."""
    return main << 16 | sub << 24


_TAKEOFF, _HOLD = _custom_mode(4, 2), _custom_mode(4, 3)
_RETURN, _LAND = _custom_mode(4, 5), _custom_mode(4, 6)
_OFFBOARD = _custom_mode(6, 0)
_MODE_NAMES = {
    _custom_mode(1, 0): "MANUAL",
    _custom_mode(2, 0): "ALTCTL",
    _custom_mode(3, 0): "POSCTL",
    _custom_mode(4, 1): "AUTO.READY",
    _TAKEOFF: "AUTO.TAKEOFF",
    _HOLD: "AUTO.LOITER",
    _custom_mode(4, 4): "AUTO.MISSION",
    _RETURN: "AUTO.RTL",
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

    usual_position_loop: ClassVar[PositionLoop] = loop_of((0.95, 1.0, 1.8, 4.0))

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

    @property
    def taken(self) -> bool:
        """Whether the vehicle left that mode unasked."""
        return self._modes.taken

    async def motion_limits(self) -> MotionLimits:
        """MPC_Z_VEL_MAX_UP and MPC_Z_VEL_MAX_DN; OFFBOARD keeps to no acceleration but by the tilt."""
        return MotionLimits(
            up_m_s=await read_parameter(self._connection, "MPC_Z_VEL_MAX_UP"),
            down_m_s=await read_parameter(self._connection, "MPC_Z_VEL_MAX_DN"),
        )

    async def position_loop(self) -> PositionLoop:
        """MPC_XY_P and MPC_Z_P over MPC_XY_VEL_P_ACC and MPC_Z_VEL_P_ACC."""
        return await read_position_loop(self._connection, (_LOOP_GAINS,))

    async def setpoint_timeout_s(self) -> float:
        """COM_OF_LOSS_T: then it does COM_OBL_RC_ACT, and goes back to OFFBOARD at the next setpoint."""
        return await steps.parameter_or(self._connection, "COM_OF_LOSS_T", _LOSS_TIMEOUT_S)

    async def arm(self) -> None:
        """Arm, unless it is armed; in AUTO.LOITER, for with no sticks PX4 arms in no mode that needs them."""
        if not self._telemetry.status.armed and self._telemetry.status.custom_mode != _HOLD:
            await self._switch_to(_HOLD)
        await steps.arm(self._connection, self._telemetry, self._modes)

    async def takeoff(self, altitude_m: float) -> None:
        """Climb to `altitude_m` above where it is; returns when it is there, or PX4 believes so."""
        start = self._telemetry.state or await self._telemetry.next_state()
        place = await request_message(self._connection, mavlink.MAVLink_global_position_int_message)
        above_sea_m = place.alt * 1e-3 + altitude_m
        await command(
            self._connection, mavlink.MAV_CMD_NAV_TAKEOFF, _NAN, 0.0, 0.0, _NAN, _NAN, _NAN, above_sea_m
        )

        def finished() -> bool:
            status = self._telemetry.status
            return status.custom_mode == _HOLD and status.landed is Landed.IN_AIR

        own = (_TAKEOFF, _HOLD)
        await steps.until_climbed(start.position, altitude_m, self._telemetry, self._modes, own, finished)
        if await self._is_held_by_another(start.position, altitude_m):
            raise TakenError(
                f"the vehicle went to {self.mode} unasked, in its climb: it was left to whoever did that"
            )

    async def _is_held_by_another(self, start: Vec3, altitude_m: float) -> bool:
        """Whether the climb ended in a hold of a failsafe, or farther below the altitude than PX4's own."""
        if self._modes.overruled:
            return True

        def short_m(state: VehicleState) -> float:
            return altitude_m - float(start[2] - state.position[2]) - _TOLERANCE_M

        newest = self._telemetry.state
        if newest is not None and short_m(newest) <= _ALTITUDE_RADIUS_M:
            return False
        radius_m = await steps.parameter_or(self._connection, "NAV_MC_ALT_RAD", _ALTITUDE_RADIUS_M)
        return short_m(await self._telemetry.next_state()) > radius_m

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
        await self._switch_to(_HOLD, attempts=HOLD_ATTEMPTS)

    async def land(self) -> None:
        """Land here; returns when the vehicle is on the ground and disarmed itself."""
        self._modes.release()
        await command(self._connection, mavlink.MAV_CMD_NAV_LAND, 0.0, 0.0, 0.0, _NAN, _NAN, _NAN, 0.0)
        await steps.until_down(self._telemetry, self._modes, (_LAND,))

    async def return_home(self) -> None:
        """Return as RTL_TYPE and its kin say; returns when the vehicle is on the ground and disarmed."""
        self._modes.release()
        await steps.return_home(self._connection, self._telemetry, self._modes, (_RETURN, _LAND))

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

    async def _switch_to(self, mode: int, attempts: int = 4) -> None:
        await self._modes.switch(mode, *_main_and_sub(mode), attempts=attempts)


def _main_and_sub(custom_mode: int) -> tuple[int, int]:
    return custom_mode >> 16 & 0xFF, custom_mode >> 24
