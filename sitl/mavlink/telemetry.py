"""What the vehicle tells of itself: for each message the function that writes it from the firmware's state.

Field for field as PX4's streams (src/modules/mavlink/streams); ArduPilot's differ where `Flavour` says so.
time_boot_ms and time_usec are the time of the simulation.
"""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass

from pymavlink.dialects.v20 import common as mavlink

from sitl.firmware.interface import Autopilot, Landed
from sitl.geodesy import HOME, Geodetic, geodetic_from_ned
from sitl.mavlink.flavour import Flavour
from sitl.mavlink.frames import Message

_Three = tuple[float, float, float]

_INT8, _INT16, _INT32 = (-(2**7), 2**7 - 1), (-(2**15), 2**15 - 1), (-(2**31), 2**31 - 1)
_UINT16 = (0, 2**16 - 1)
_NAN = math.nan
_NO_COVARIANCE = [_NAN] * 21
_UNKNOWN_CELL_MV = 65535
_UID = 0x5349544C << 8  # "SITL"


@dataclass(frozen=True, slots=True)
class Report:
    """The firmware's state at one instant, in the plain numbers that messages are made of.

    Attributes:
        firmware: the autopilot that reports.
        flavour: how it speaks.
        system_id: MAVLink id of the vehicle.
        rotors: how many it has.
        time_s: time since boot (s), of the simulation.
        position, velocity: NED (m, m/s).
        quaternion: body to NED; w, x, y, z.
        euler: roll, pitch, yaw (rad), z-y'-x'' from NED.
        rates: body rates (rad/s).
        gps: where the GPS receiver has the vehicle; NED (m).
        resets: of the estimate, so far.
        position_ok: whether the position is known.
    """

    firmware: Autopilot
    flavour: Flavour
    system_id: int
    rotors: int
    time_s: float
    position: _Three
    velocity: _Three
    quaternion: tuple[float, float, float, float]
    euler: _Three
    rates: _Three
    gps: _Three
    resets: int
    position_ok: bool

    @property
    def time_ms(self) -> int:
        """As time_boot_ms."""
        return round(self.time_s * 1e3)

    @property
    def time_us(self) -> int:
        """As time_usec."""
        return round(self.time_s * 1e6)

    @property
    def heading_deg(self) -> float:
        """Clockwise from north, 0 to 360."""
        return math.degrees(self.euler[2]) % 360.0

    @property
    def above_home_m(self) -> float:
        """Height above home."""
        return float(self.firmware.plans.home[2]) - self.position[2]

    @property
    def place(self) -> Geodetic:
        """Where the estimate is on the map."""
        return geodetic_from_ned(*self.position, self.flavour.earth_radius_m)


_NEED_POSITION = frozenset(
    (
        mavlink.MAVLINK_MSG_ID_LOCAL_POSITION_NED,
        mavlink.MAVLINK_MSG_ID_GLOBAL_POSITION_INT,
        mavlink.MAVLINK_MSG_ID_ODOMETRY,
        mavlink.MAVLINK_MSG_ID_HOME_POSITION,
        mavlink.MAVLINK_MSG_ID_GPS_GLOBAL_ORIGIN,
    )
)


def written(message_id: int, state: Report) -> Message | None:
    """The message of that id now; None if the vehicle does not know it, or knows no position for it."""
    write = state.flavour.writers.get(message_id)
    if write is None or (message_id in _NEED_POSITION and not state.position_ok):
        return None
    return write(state)


def report(firmware: Autopilot, flavour: Flavour, system_id: int, rotors: int, time_s: float) -> Report:
    """The state of `firmware` now."""
    estimate = firmware.estimate
    w, x, y, z = estimate.attitude.tolist()
    euler = (
        math.atan2(2.0 * (w * x + y * z), 1.0 - 2.0 * (x * x + y * y)),
        math.asin(max(-1.0, min(1.0, 2.0 * (w * y - z * x)))),
        math.atan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (y * y + z * z)),
    )
    return Report(
        firmware,
        flavour,
        system_id,
        rotors,
        time_s,
        position=tuple(estimate.position.tolist()),
        velocity=tuple(estimate.velocity.tolist()),
        quaternion=(w, x, y, z),
        euler=euler,
        rates=tuple(estimate.rates.tolist()),
        gps=tuple(estimate.gps.tolist()),
        resets=estimate.resets,
        position_ok=firmware.position_ok,
    )


def _limited(value: float, limits: tuple[int, int]) -> int:
    """The nearest whole number within the limits of its field; 0 for NaN, which no integer can tell."""
    return 0 if math.isnan(value) else round(min(max(value, limits[0]), limits[1]))


def heartbeat(state: Report) -> Message:
    """HEARTBEAT: mode, armed, failsafe."""
    firmware, flavour = state.firmware, state.flavour
    return mavlink.MAVLink_heartbeat_message(
        type=mavlink.MAV_TYPE_QUADROTOR,
        autopilot=flavour.autopilot,
        base_mode=flavour.base_mode(firmware.mode, firmware.armed),
        custom_mode=flavour.custom_modes[firmware.mode],
        system_status=flavour.system_status(firmware),
        mavlink_version=3,
    )


def autopilot_version(state: Report) -> Message:
    """AUTOPILOT_VERSION: what this vehicle can do, and as which release of its firmware it behaves."""
    return mavlink.MAVLink_autopilot_version_message(
        capabilities=state.flavour.capabilities,
        flight_sw_version=state.flavour.version,
        middleware_sw_version=state.flavour.version,
        os_sw_version=0,
        board_version=0,
        flight_custom_version=[0] * 8,
        middleware_custom_version=[0] * 8,
        os_custom_version=[0] * 8,
        vendor_id=0,
        product_id=0,
        uid=_UID + state.system_id,
    )


_SENSORS = (
    mavlink.MAV_SYS_STATUS_SENSOR_3D_GYRO
    | mavlink.MAV_SYS_STATUS_SENSOR_3D_ACCEL
    | mavlink.MAV_SYS_STATUS_SENSOR_3D_MAG
    | mavlink.MAV_SYS_STATUS_SENSOR_ABSOLUTE_PRESSURE
)
_GPS = mavlink.MAV_SYS_STATUS_SENSOR_GPS
_PREARM_CHECK = mavlink.MAV_SYS_STATUS_PREARM_CHECK
_ALWAYS_HEALTHY = (
    mavlink.MAV_SYS_STATUS_SENSOR_MOTOR_OUTPUTS
    | mavlink.MAV_SYS_STATUS_SENSOR_BATTERY
    | mavlink.MAV_SYS_STATUS_AHRS
)
_PRESENT = _SENSORS | _GPS | _PREARM_CHECK | _ALWAYS_HEALTHY


def sys_status(state: Report) -> Message:
    """SYS_STATUS: health of sensors, position and arming checks, and the battery."""
    health, battery = state.firmware.health, state.firmware.battery
    healthy = (
        _ALWAYS_HEALTHY
        | (_SENSORS if health.sensors_ok else 0)
        | (_GPS if health.gps_ok else 0)
        | (_PREARM_CHECK if health.ready_to_arm else 0)
    )
    return mavlink.MAVLink_sys_status_message(
        onboard_control_sensors_present=_PRESENT,
        onboard_control_sensors_enabled=_PRESENT,
        onboard_control_sensors_health=healthy,
        load=0,
        voltage_battery=_limited(battery.voltage_v * 1e3, _UINT16),
        current_battery=_limited(battery.current_a * 1e2, _INT16),
        battery_remaining=_limited(battery.remaining * 1e2, _INT8),
        drop_rate_comm=0,
        errors_comm=0,
        errors_count1=0,
        errors_count2=0,
        errors_count3=0,
        errors_count4=0,
    )


def battery_status(state: Report) -> Message:
    """BATTERY_STATUS: the pack as one cell."""
    battery = state.firmware.battery
    return mavlink.MAVLink_battery_status_message(
        id=0,
        battery_function=mavlink.MAV_BATTERY_FUNCTION_ALL,
        type=mavlink.MAV_BATTERY_TYPE_LIPO,
        temperature=32767,  # unknown
        voltages=[_limited(battery.voltage_v * 1e3, _UINT16)] + [_UNKNOWN_CELL_MV] * 9,
        current_battery=_limited(battery.current_a * 1e2, _INT16),
        current_consumed=-1,
        energy_consumed=-1,
        battery_remaining=_limited(battery.remaining * 1e2, _INT8),
        charge_state=mavlink.MAV_BATTERY_CHARGE_STATE_OK,
    )


def attitude(state: Report) -> Message:
    """ATTITUDE: roll, pitch, yaw and body rates."""
    return mavlink.MAVLink_attitude_message(state.time_ms, *state.euler, *state.rates)


def attitude_quaternion(state: Report) -> Message:
    """ATTITUDE_QUATERNION: body to NED, and body rates."""
    return mavlink.MAVLink_attitude_quaternion_message(state.time_ms, *state.quaternion, *state.rates)


def local_position_ned(state: Report) -> Message:
    """LOCAL_POSITION_NED: position and velocity."""
    return mavlink.MAVLink_local_position_ned_message(state.time_ms, *state.position, *state.velocity)


def odometry(state: Report) -> Message:
    """ODOMETRY: pose and velocity in NED, as PX4's EKF2 gives them."""
    return mavlink.MAVLink_odometry_message(
        state.time_us,
        mavlink.MAV_FRAME_LOCAL_NED,
        mavlink.MAV_FRAME_LOCAL_NED,
        *state.position,
        state.quaternion,
        *state.velocity,
        *state.rates,
        pose_covariance=_NO_COVARIANCE,
        velocity_covariance=_NO_COVARIANCE,
        reset_counter=state.resets % 256,
        estimator_type=mavlink.MAV_ESTIMATOR_TYPE_AUTOPILOT,
        quality=100,
    )


def global_position_int(state: Report) -> Message:
    """GLOBAL_POSITION_INT: the estimate as latitude, longitude and altitudes."""
    place, (north, east, down) = state.place, state.velocity
    return mavlink.MAVLink_global_position_int_message(
        state.time_ms,
        _limited(place.latitude_deg * 1e7, _INT32),
        _limited(place.longitude_deg * 1e7, _INT32),
        _limited(place.altitude_m * 1e3, _INT32),
        _limited(state.above_home_m * 1e3, _INT32),
        _limited(north * 1e2, _INT16),
        _limited(east * 1e2, _INT16),
        _limited(down * 1e2, _INT16),
        _limited(state.heading_deg * 1e2, _UINT16) % 36000,
    )


def gps_raw_int(state: Report) -> Message:
    """GPS_RAW_INT: a receiver with a good 3-D fix where the vehicle truly is, or without any satellites."""
    place = geodetic_from_ned(*state.gps, state.flavour.earth_radius_m)
    north, east, _ = state.velocity
    has_fix = state.firmware.health.gps_ok
    return mavlink.MAVLink_gps_raw_int_message(
        time_usec=state.time_us,
        fix_type=mavlink.GPS_FIX_TYPE_3D_FIX if has_fix else mavlink.GPS_FIX_TYPE_NO_FIX,
        lat=_limited(place.latitude_deg * 1e7, _INT32),
        lon=_limited(place.longitude_deg * 1e7, _INT32),
        alt=_limited(place.altitude_m * 1e3, _INT32),
        eph=80,
        epv=90,
        vel=_limited(math.hypot(north, east) * 1e2, _UINT16),
        cog=_limited(math.degrees(math.atan2(east, north)) % 360.0 * 1e2, _UINT16) % 36000,
        satellites_visible=12 if has_fix else 0,
        h_acc=900,
        v_acc=1780,
    )


def altitude(state: Report) -> Message:
    """ALTITUDE: above the sea and above home."""
    above_home_m = state.above_home_m
    return mavlink.MAVLink_altitude_message(
        time_usec=state.time_us,
        altitude_monotonic=state.place.altitude_m,
        altitude_amsl=state.place.altitude_m,
        altitude_local=-state.position[2],
        altitude_relative=above_home_m,
        altitude_terrain=_NAN,
        bottom_clearance=-state.position[2],
    )


def vfr_hud(state: Report) -> Message:
    """VFR_HUD: speed, heading and climb for displays."""
    north, east, down = state.velocity
    speed = math.hypot(north, east)
    return mavlink.MAVLink_vfr_hud_message(
        airspeed=speed,
        groundspeed=speed,
        heading=_limited(state.heading_deg, _INT16) % 360,
        throttle=round(100.0 * state.firmware.attitude_target.thrust),
        alt=state.place.altitude_m,
        climb=-down,
    )


def home_position(state: Report) -> mavlink.MAVLink_home_position_message:
    """HOME_POSITION: what altitudes count from, and where a return ends."""
    north, east, down = state.firmware.plans.home.tolist()
    home = geodetic_from_ned(north, east, down, state.flavour.earth_radius_m)
    return mavlink.MAVLink_home_position_message(
        latitude=round(home.latitude_deg * 1e7),
        longitude=round(home.longitude_deg * 1e7),
        altitude=round(home.altitude_m * 1e3),
        x=north,
        y=east,
        z=down,
        q=[1.0, 0.0, 0.0, 0.0],
        approach_x=0.0,
        approach_y=0.0,
        approach_z=0.0,
        time_usec=state.time_us,
    )


def gps_global_origin(state: Report) -> Message:
    """GPS_GLOBAL_ORIGIN: where the local frame has its zero."""
    return mavlink.MAVLink_gps_global_origin_message(
        latitude=round(HOME.latitude_deg * 1e7),
        longitude=round(HOME.longitude_deg * 1e7),
        altitude=round(HOME.altitude_m * 1e3),
        time_usec=state.time_us,
    )


_LANDED_STATES = {
    Landed.ON_GROUND: mavlink.MAV_LANDED_STATE_ON_GROUND,
    Landed.IN_AIR: mavlink.MAV_LANDED_STATE_IN_AIR,
    Landed.TAKING_OFF: mavlink.MAV_LANDED_STATE_TAKEOFF,
    Landed.LANDING: mavlink.MAV_LANDED_STATE_LANDING,
}


def extended_sys_state(state: Report) -> Message:
    """EXTENDED_SYS_STATE: on the ground or in the air."""
    return mavlink.MAVLink_extended_sys_state_message(
        mavlink.MAV_VTOL_STATE_UNDEFINED, _LANDED_STATES[state.firmware.landed]
    )


def timesync_request(state: Report) -> Message:
    """TIMESYNC: asks the peer for its time; ts1 comes back with the answer."""
    return mavlink.MAVLink_timesync_message(tc1=0, ts1=round(state.time_s * 1e9))


def ping_request(state: Report) -> Message:
    """PING: asks whoever hears it for an answer."""
    return mavlink.MAVLink_ping_message(
        time_usec=state.time_us, seq=state.time_ms, target_system=0, target_component=0
    )


WRITERS: Mapping[int, Callable[[Report], Message]] = {
    mavlink.MAVLINK_MSG_ID_HEARTBEAT: heartbeat,
    mavlink.MAVLINK_MSG_ID_SYS_STATUS: sys_status,
    mavlink.MAVLINK_MSG_ID_PING: ping_request,
    mavlink.MAVLINK_MSG_ID_GPS_RAW_INT: gps_raw_int,
    mavlink.MAVLINK_MSG_ID_ATTITUDE: attitude,
    mavlink.MAVLINK_MSG_ID_ATTITUDE_QUATERNION: attitude_quaternion,
    mavlink.MAVLINK_MSG_ID_LOCAL_POSITION_NED: local_position_ned,
    mavlink.MAVLINK_MSG_ID_GLOBAL_POSITION_INT: global_position_int,
    mavlink.MAVLINK_MSG_ID_GPS_GLOBAL_ORIGIN: gps_global_origin,
    mavlink.MAVLINK_MSG_ID_VFR_HUD: vfr_hud,
    mavlink.MAVLINK_MSG_ID_TIMESYNC: timesync_request,
    mavlink.MAVLINK_MSG_ID_ALTITUDE: altitude,
    mavlink.MAVLINK_MSG_ID_BATTERY_STATUS: battery_status,
    mavlink.MAVLINK_MSG_ID_AUTOPILOT_VERSION: autopilot_version,
    mavlink.MAVLINK_MSG_ID_HOME_POSITION: home_position,
    mavlink.MAVLINK_MSG_ID_EXTENDED_SYS_STATE: extended_sys_state,
    mavlink.MAVLINK_MSG_ID_ODOMETRY: odometry,
}
"""What every autopilot can stream or be asked for, by message id."""
