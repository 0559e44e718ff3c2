"""What the vehicle is doing, and how it is, by its HEARTBEAT, EXTENDED_SYS_STATE, SYS_STATUS and the like.

ArduPilot's HOME_POSITION has 0 for its local coordinates, wherever home is; so they are worked out from its
place on the Earth and that of the origin, GPS_GLOBAL_ORIGIN.
"""

import math
from dataclasses import dataclass, replace
from enum import Enum

import numpy as np

from companion import clock
from companion.arrays import Vec3
from companion.geodesy import ARDUPILOT_EARTH, Place, ned_from_geodetic
from companion.link.connection import Connection
from companion.link.dialect import mavlink
from companion.link.estimator import Estimator, of_ardupilot, of_px4
from companion.link.gps import GpsComparison

_AT_REST_S = 10.0
"""A vehicle that is on the ground for so long and still armed does not disarm itself (COM_DISARM_LAND 0)."""
_MODE_TOLD_FOR_S = 1.0
"""PX4 sends CURRENT_MODE at every change, and twice a second without one."""


class Landed(Enum):
    """Where the vehicle is, as its land detector has it."""

    UNDEFINED = mavlink.MAV_LANDED_STATE_UNDEFINED
    ON_GROUND = mavlink.MAV_LANDED_STATE_ON_GROUND
    IN_AIR = mavlink.MAV_LANDED_STATE_IN_AIR
    TAKEOFF = mavlink.MAV_LANDED_STATE_TAKEOFF
    LANDING = mavlink.MAV_LANDED_STATE_LANDING


@dataclass(frozen=True, slots=True, eq=False)
class VehicleStatus:
    """What the vehicle is doing.

    Attributes:
        armed: whether its motors may turn.
        custom_mode: its flight mode, in the autopilot's own numbers.
        landed: where it is.
        battery: remaining charge (0 to 1); None when it does not tell.
        home: in NED of its local origin (m); None until it tells.
        landed_s: since when it is `landed` so (companion clock, s).
        estimator: largest innovation test ratio; infinite where a part of the estimate is missing, NaN where
            it does not tell.
        gps_lost_s: since when there is no fix in three dimensions any more (companion clock, s); infinite
            where there is one, or never was.
        setpoint: the position that it says it follows (NED, m), a new object each time that it says so; None
            until it does.
        gps_apart_m: how far the estimate is from where GPS has the vehicle (m), as `GpsComparison` has it;
            NaN where it is not known.
    """

    armed: bool
    custom_mode: int
    landed: Landed = Landed.UNDEFINED
    battery: float | None = None
    home: Vec3 | None = None
    landed_s: float = math.inf
    estimator: float = math.nan
    gps_lost_s: float = math.inf
    gps_apart_m: float = math.nan
    setpoint: Vec3 | None = None

    def is_down(self, now_s: float) -> bool:
        """Whether a landing is over: it is on the ground, and disarmed, or does not disarm itself."""
        at_rest = not self.armed or now_s >= self.landed_s + _AT_REST_S
        return self.landed is Landed.ON_GROUND and at_rest


class StatusWatch:
    """Keeps the newest status of a connection's vehicle, in `status`."""

    def __init__(self, connection: Connection) -> None:
        self.status = VehicleStatus(*_armed_and_mode(connection.heartbeat))
        self._mode_told_s = -math.inf
        self._had_fix = False
        self._gps = GpsComparison()
        connection.subscribe(mavlink.MAVLink_heartbeat_message, self._on_heartbeat)
        connection.subscribe(mavlink.MAVLink_current_mode_message, self._on_current_mode)
        connection.subscribe(mavlink.MAVLink_extended_sys_state_message, self._on_extended_state)
        connection.subscribe(mavlink.MAVLink_sys_status_message, self._on_system_status)
        connection.subscribe(mavlink.MAVLink_gps_raw_int_message, self._on_gps)
        connection.subscribe(
            mavlink.MAVLink_global_position_int_message, lambda told: self._gps.estimate(told, clock.now())
        )
        connection.subscribe(mavlink.MAVLink_position_target_local_ned_message, self._on_setpoint)
        connection.subscribe(
            mavlink.MAVLink_estimator_status_message, lambda told: self._take_estimator(of_px4(told))
        )
        connection.subscribe(
            mavlink.MAVLink_ekf_status_report_message, lambda told: self._take_estimator(of_ardupilot(told))
        )
        if connection.heartbeat.autopilot == mavlink.MAV_AUTOPILOT_ARDUPILOTMEGA:
            self._home_place: Place | None = None
            self._origin: Place | None = None
            connection.subscribe(mavlink.MAVLink_home_position_message, self._on_home_place)
            connection.subscribe(mavlink.MAVLink_gps_global_origin_message, self._on_origin)
        else:
            connection.subscribe(mavlink.MAVLink_home_position_message, self._on_home)

    def _on_heartbeat(self, message: mavlink.MAVLink_heartbeat_message) -> None:
        armed, custom_mode = _armed_and_mode(message)
        if clock.now() < self._mode_told_s + _MODE_TOLD_FOR_S:  # this heartbeat may be the older of the two
            custom_mode = self.status.custom_mode
        self.status = replace(self.status, armed=armed, custom_mode=custom_mode)

    def _on_current_mode(self, message: mavlink.MAVLink_current_mode_message) -> None:
        self._mode_told_s = clock.now()
        self.status = replace(self.status, custom_mode=message.custom_mode)

    def _on_extended_state(self, message: mavlink.MAVLink_extended_sys_state_message) -> None:
        known = message.landed_state in _LANDED_STATES
        landed = Landed(message.landed_state) if known else Landed.UNDEFINED
        if landed is not self.status.landed:
            self.status = replace(self.status, landed=landed, landed_s=clock.now())

    def _on_system_status(self, message: mavlink.MAVLink_sys_status_message) -> None:
        percent = message.battery_remaining
        self.status = replace(self.status, battery=percent / 100.0 if percent >= 0 else None)

    def _on_gps(self, message: mavlink.MAVLink_gps_raw_int_message) -> None:
        has_fix = message.fix_type >= mavlink.GPS_FIX_TYPE_3D_FIX
        self._had_fix = self._had_fix or has_fix
        lost_s = min(self.status.gps_lost_s, clock.now()) if self._had_fix and not has_fix else math.inf
        apart_m = self._gps.fix(message, clock.now())
        self.status = replace(self.status, gps_lost_s=lost_s, gps_apart_m=apart_m)

    def _on_setpoint(self, message: mavlink.MAVLink_position_target_local_ned_message) -> None:
        if not message.type_mask & _NO_POSITION and math.isfinite(message.x + message.y + message.z):
            self.status = replace(self.status, setpoint=np.array([message.x, message.y, message.z]))

    def _take_estimator(self, told: Estimator) -> None:
        self.status = replace(self.status, estimator=math.inf if told.missing else told.worst_ratio)

    def _on_home(self, message: mavlink.MAVLink_home_position_message) -> None:
        if math.isfinite(message.x + message.y + message.z):
            self.status = replace(self.status, home=np.array([message.x, message.y, message.z]))

    def _on_home_place(self, message: mavlink.MAVLink_home_position_message) -> None:
        self._home_place = _place(message)
        self._locate_home()

    def _on_origin(self, message: mavlink.MAVLink_gps_global_origin_message) -> None:
        self._origin = _place(message)
        self._locate_home()

    def _locate_home(self) -> None:
        if self._home_place is not None and self._origin is not None:
            home = ned_from_geodetic(self._home_place, self._origin, ARDUPILOT_EARTH)
            self.status = replace(self.status, home=home)


_NO_POSITION = (
    mavlink.POSITION_TARGET_TYPEMASK_X_IGNORE
    | mavlink.POSITION_TARGET_TYPEMASK_Y_IGNORE
    | mavlink.POSITION_TARGET_TYPEMASK_Z_IGNORE
)
_LANDED_STATES = {landed.value for landed in Landed}


def _armed_and_mode(message: mavlink.MAVLink_heartbeat_message) -> tuple[bool, int]:
    return bool(message.base_mode & mavlink.MAV_MODE_FLAG_SAFETY_ARMED), message.custom_mode


def _place(
    message: mavlink.MAVLink_home_position_message | mavlink.MAVLink_gps_global_origin_message,
) -> Place:
    return Place(message.latitude * 1e-7, message.longitude * 1e-7, message.altitude * 1e-3)
