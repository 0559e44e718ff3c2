"""ArduPilot Copter: GUIDED as https://ardupilot.org/dev/docs/copter-commands-in-guided-mode.html has it."""

from typing import ClassVar

from companion import clock
from companion.arrays import Vec3
from companion.autopilot import steps
from companion.autopilot.flight_modes import HOLD_ATTEMPTS, FlightModes
from companion.autopilot.interface import MotionLimits
from companion.autopilot.position_loop import PositionLoop, loop_of, read_position_loop
from companion.autopilot.setpoint import position_target
from companion.errors import NoReplyError, RefusedError
from companion.link.command import command, request_message
from companion.link.connection import Connection
from companion.link.dialect import mavlink
from companion.link.parameter import read_parameter
from companion.link.telemetry import Telemetry

_POSITION_WITHIN_S = 30.0
"""How long the estimator may take from power-up until it uses GPS; its position comes from then on."""

_GUIDED_TIMEOUT_S = 3.0
_GUIDED, _RTL, _LAND, _BRAKE = 4, 6, 9, 17
_MODE_NAMES = {
    0: "STABILIZE",
    1: "ACRO",
    2: "ALT_HOLD",
    3: "AUTO",
    _GUIDED: "GUIDED",
    5: "LOITER",
    _RTL: "RTL",
    7: "CIRCLE",
    _LAND: "LAND",
    11: "DRIFT",
    13: "SPORT",
    16: "POSHOLD",
    _BRAKE: "BRAKE",
    18: "THROW",
    20: "GUIDED_NOGPS",
    21: "SMART_RTL",
    22: "FLOWHOLD",
    23: "FOLLOW",
    27: "AUTO_RTL",
}

_MOTION_LIMITS = (
    (("WPNAV_SPEED_UP", "WPNAV_SPEED_DN", "WPNAV_ACCEL", "WPNAV_ACCEL_Z"), 0.01),
    (("WP_SPD_UP", "WP_SPD_DN", "WP_ACC", "WP_ACC_Z"), 1.0),  # names and unit from version 4.7 on
)
"""Parameters of what GUIDED keeps to, in the order of `MotionLimits`, and their unit (SI)."""

_LOOP_GAINS = (
    ("PSC_POSXY_P", "PSC_POSZ_P", "PSC_VELXY_P", "PSC_VELZ_P"),
    ("PSC_NE_POS_P", "PSC_D_POS_P", "PSC_NE_VEL_P", "PSC_D_VEL_P"),  # names from version 4.7 on
)
_SHAPED = 3.0
"""GUIDED smooths what it is sent within limits of jerk, which leaves less room for corrections than the gains
say: the simulated vehicle begins to swing at a stiffness that PX4 still bears (docs/decisions.md)."""


def mode_name(custom_mode: int) -> str:
    """The name of the flight mode in HEARTBEAT.custom_mode."""
    return _MODE_NAMES.get(custom_mode, f"mode {custom_mode}")


def _shaped(loop: PositionLoop) -> PositionLoop:
    return PositionLoop(_SHAPED * loop.stiffness_1_s2, _SHAPED * loop.damping_1_s)


class ArduPilot:
    """A multirotor that ArduPilot flies, as an `Autopilot`.

    When setpoints with a velocity stop, the vehicle goes on for GUID_TIMEOUT (3 s unless set), then stops
    and stays in GUIDED.
    """

    usual_position_loop: ClassVar[PositionLoop] = _shaped(loop_of((1.0, 1.0, 2.0, 5.0)))

    def __init__(self, connection: Connection, telemetry: Telemetry) -> None:
        self._connection = connection
        self._telemetry = telemetry
        self._modes = FlightModes(connection, telemetry, mode_name, _GUIDED)

    @property
    def mode(self) -> str:
        """The flight mode, by ArduPilot's own name."""
        return self._modes.now

    @property
    def engaged(self) -> bool:
        """Whether the vehicle is in GUIDED because we asked for it."""
        return self._modes.engaged

    @property
    def taken(self) -> bool:
        """Whether the vehicle left that mode unasked."""
        return self._modes.taken

    async def motion_limits(self) -> MotionLimits:
        """What GUIDED keeps to."""
        for names, unit in _MOTION_LIMITS:
            try:
                return MotionLimits(*[unit * await read_parameter(self._connection, name) for name in names])
            except NoReplyError:
                continue
        raise NoReplyError(
            f"the vehicle answered for none of {', '.join(names[0] for names, _ in _MOTION_LIMITS)}"
        )

    async def position_loop(self) -> PositionLoop:
        """PSC_POSXY_P and PSC_POSZ_P over PSC_VELXY_P and PSC_VELZ_P, as felt behind GUIDED's shaping."""
        return _shaped(await read_position_loop(self._connection, _LOOP_GAINS))

    async def setpoint_timeout_s(self) -> float:
        """GUID_TIMEOUT: after it the vehicle stops where it is, and stays in GUIDED."""
        return await steps.parameter_or(self._connection, "GUID_TIMEOUT", _GUIDED_TIMEOUT_S)

    async def arm(self) -> None:
        """Switch to GUIDED, in which a takeoff can be asked for, and arm, unless it is armed.

        With its arming checks off, ArduPilot arms before it knows where it is, and then does not take off:
        so its position is waited for.
        """
        await self._telemetry.next_state(_POSITION_WITHIN_S)
        await self._switch_to(_GUIDED)
        await steps.arm(self._connection, self._telemetry, self._modes)

    async def takeoff(self, altitude_m: float) -> None:
        """Climb to `altitude_m` above where it is; returns when it is there."""
        start = self._telemetry.state or await self._telemetry.next_state()
        place = await request_message(self._connection, mavlink.MAVLink_global_position_int_message)
        above_home_m = place.relative_alt * 1e-3 + altitude_m
        try:
            await command(self._connection, mavlink.MAV_CMD_NAV_TAKEOFF, 0, 0, 0, 0, 0, 0, above_home_m)
        except RefusedError as refusal:  # ArduPilot gives no reason for this one
            raise RefusedError(
                f"{refusal}; it takes off only from the ground, armed, in GUIDED (now {self.mode}), upwards"
            ) from refusal
        await steps.until_climbed(start.position, altitude_m, self._telemetry, self._modes, (_GUIDED,))

    async def engage(self) -> None:
        """Switch to GUIDED, in which setpoints are followed from the first one on."""
        await self._switch_to(_GUIDED)
        self._modes.engage()

    async def hold(self) -> None:
        """Switch to BRAKE, which stops and holds whatever the sticks of a remote control say.

        In LOITER they count, and one whose throttle stick is down brings the vehicle down; staying in GUIDED
        would leave it to every setpoint that is still under way.
        """
        self._modes.release()
        await self._switch_to(_BRAKE, attempts=HOLD_ATTEMPTS)

    async def land(self) -> None:
        """Land here; returns when the vehicle is on the ground and disarmed itself."""
        self._modes.release()
        await command(self._connection, mavlink.MAV_CMD_NAV_LAND)
        await steps.until_down(self._telemetry, self._modes, (_LAND,))

    async def return_home(self) -> None:
        """Return as RTL_ALT and its kin say; returns when the vehicle is on the ground and disarmed."""
        self._modes.release()
        await steps.return_home(self._connection, self._telemetry, self._modes, (_RTL, _LAND))

    async def until_taken(self) -> str:
        """Wait until the vehicle leaves GUIDED unasked; the name of the mode that it went to."""
        return await self._modes.until_taken()

    def send_setpoint(
        self,
        position: Vec3 | None,
        velocity: Vec3 | None = None,
        acceleration: Vec3 | None = None,
        yaw: float | None = None,
    ) -> None:
        """Send one setpoint, now; ArduPilot drops it when it is not in GUIDED."""
        if position is not None and velocity is None:
            acceleration = None  # GUIDED takes these two only with a velocity, and stops otherwise
        target = self._connection.target
        self._connection.send(position_target(target, clock.now(), position, velocity, acceleration, yaw))

    async def _switch_to(self, mode: int, attempts: int = 4) -> None:
        await self._modes.switch(mode, mode, attempts=attempts)
