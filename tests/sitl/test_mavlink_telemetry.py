import math
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from mavlink_fakes import FakeFirmware
from pymavlink.dialects.v20 import common as mavlink

from sitl.firmware.interface import Battery, Health, Landed, Mode, Setpoint
from sitl.geodesy import ARDUPILOT_EARTH_M, HOME, geodetic_from_ned, ned_from_geodetic
from sitl.mavlink.ardupilot import ARDUPILOT
from sitl.mavlink.flavour import Flavour
from sitl.mavlink.px4 import PX4
from sitl.mavlink.telemetry import report
from sitl.mavlink.wellbeing import ekf_status_report


def written(name: str, firmware: FakeFirmware | None = None, time_s: float = 12.345) -> dict[str, Any]:
    """The fields of a message after its way over the wire."""
    state = report(firmware or FakeFirmware(), PX4, 1, 4, time_s)
    message = PX4.writers[getattr(mavlink, f"MAVLINK_MSG_ID_{name}")](state)
    (received,) = mavlink.MAVLink(None).parse_buffer(message.pack(mavlink.MAVLink(None, 1, 1))) or []
    assert received.get_type() == name
    return {field: getattr(received, field) for field in received.get_fieldnames()}


def quaternion(roll: float, pitch: float, yaw: float) -> np.ndarray:
    (sr, cr), (sp, cp), (sy, cy) = ((math.sin(a / 2), math.cos(a / 2)) for a in (roll, pitch, yaw))
    return np.array(
        [
            cr * cp * cy + sr * sp * sy,
            sr * cp * cy - cr * sp * sy,
            cr * sp * cy + sr * cp * sy,
            cr * cp * sy - sr * sp * cy,
        ]
    )


@pytest.mark.parametrize("flavour", [PX4, ARDUPILOT], ids=["px4", "ardupilot"])
def test_every_writer_writes_its_own_message(flavour: Flavour) -> None:
    state = report(FakeFirmware(), flavour, 1, 4, 1.0)
    assert {number: write(state).get_msgId() for number, write in flavour.writers.items()} == {
        number: number for number in flavour.writers
    }


def test_local_position_is_ned_in_metres() -> None:
    fields = written("LOCAL_POSITION_NED")
    assert fields == {
        "time_boot_ms": 12345,
        **{"x": 1.0, "y": 2.0, "z": -3.0},
        **{"vx": 0.5, "vy": -0.25, "vz": 0.125},
    }


def test_odometry_counts_the_jumps_of_the_estimate() -> None:
    assert written("ODOMETRY", FakeFirmware(resets=258))["reset_counter"] == 2


@given(st.floats(-3.0, 3.0), st.floats(-1.5, 1.5), st.floats(-3.1, 3.1))
def test_attitude_is_roll_pitch_yaw(roll: float, pitch: float, yaw: float) -> None:
    fields = written("ATTITUDE", FakeFirmware(attitude=quaternion(roll, pitch, yaw)))
    assert [fields["roll"], fields["pitch"], fields["yaw"]] == pytest.approx([roll, pitch, yaw], abs=1e-5)
    assert fields["yawspeed"] == pytest.approx(0.3)


def test_global_position_is_where_the_local_one_is() -> None:
    fields = written("GLOBAL_POSITION_INT", FakeFirmware(attitude=quaternion(0.0, 0.0, -math.pi / 2)))
    assert fields["relative_alt"] == 3000
    assert fields["alt"] == 491_000
    assert (fields["vx"], fields["vy"], fields["vz"], fields["hdg"]) == (50, -25, 12, 27000)
    north_m = (fields["lat"] * 1e-7 - HOME.latitude_deg) * 111_194.9
    assert north_m == pytest.approx(1.0, abs=0.01)


@given(*[st.floats(-500.0, 500.0)] * 3)
def test_geodetic_and_local_are_inverse(north: float, east: float, down: float) -> None:
    back = ned_from_geodetic(geodetic_from_ned(north, east, down))
    assert ned_from_geodetic(geodetic_from_ned(north, east, down), ARDUPILOT_EARTH_M)[0] == pytest.approx(
        north * 6378.1 / 6371.0, abs=1e-6
    )
    assert back == pytest.approx((north, east, down), abs=1e-6)


def test_a_degree_of_longitude_is_shorter_than_one_of_latitude() -> None:
    assert geodetic_from_ned(0.0, 100.0, 0.0).longitude_deg - HOME.longitude_deg == pytest.approx(
        100.0 / (111_194.9 * math.cos(math.radians(HOME.latitude_deg)))
    )


@pytest.mark.parametrize(
    ("mode", "main", "sub"),
    [
        (Mode.POSCTL, 3, 0),
        (Mode.TAKEOFF, 4, 2),
        (Mode.HOLD, 4, 3),
        (Mode.RTL, 4, 5),
        (Mode.LAND, 4, 6),
        (Mode.OFFBOARD, 6, 0),
    ],
)
def test_heartbeat_has_px4s_modes(mode: Mode, main: int, sub: int) -> None:
    fields = written("HEARTBEAT", FakeFirmware(mode=mode))
    assert fields["custom_mode"] == main << 16 | sub << 24
    assert fields["autopilot"] == mavlink.MAV_AUTOPILOT_PX4


@pytest.mark.parametrize(
    ("armed", "failsafe", "status"),
    [
        (False, False, mavlink.MAV_STATE_STANDBY),
        (True, False, mavlink.MAV_STATE_ACTIVE),
        (True, True, mavlink.MAV_STATE_CRITICAL),
    ],
)
def test_heartbeat_tells_armed_and_failsafe(armed: bool, failsafe: bool, status: int) -> None:
    fields = written("HEARTBEAT", FakeFirmware(armed=armed, failsafe=failsafe))
    assert fields["system_status"] == status
    assert bool(fields["base_mode"] & mavlink.MAV_MODE_FLAG_SAFETY_ARMED) is armed


@pytest.mark.parametrize(
    ("health", "bit"),
    [
        (
            Health(sensors_ok=False, gps_ok=True, position_ok=True, ready_to_arm=True),
            mavlink.MAV_SYS_STATUS_SENSOR_3D_GYRO,
        ),
        (
            Health(sensors_ok=True, gps_ok=False, position_ok=True, ready_to_arm=True),
            mavlink.MAV_SYS_STATUS_SENSOR_GPS,
        ),
        (
            Health(sensors_ok=True, gps_ok=True, position_ok=True, ready_to_arm=False),
            mavlink.MAV_SYS_STATUS_PREARM_CHECK,
        ),
    ],
)
def test_sys_status_clears_the_bit_of_what_is_not_well(health: Health, bit: int) -> None:
    fields = written("SYS_STATUS", FakeFirmware(health=health))
    assert not fields["onboard_control_sensors_health"] & bit
    assert fields["onboard_control_sensors_present"] & bit
    assert written("SYS_STATUS")["onboard_control_sensors_health"] & bit


def test_battery() -> None:
    fields = written("BATTERY_STATUS", FakeFirmware(battery=Battery(11.1, 4.2, 0.42)))
    assert (fields["voltages"], fields["battery_remaining"]) == ([11100] + [65535] * 9, 42)
    assert written("SYS_STATUS", FakeFirmware(battery=Battery(11.1, 4.2, 0.42)))["voltage_battery"] == 11100


def test_landed_state() -> None:
    assert written("EXTENDED_SYS_STATE", FakeFirmware(landed=Landed.IN_AIR))["landed_state"] == 2


def test_position_target_masks_what_is_off() -> None:
    firmware = FakeFirmware(setpoints=[Setpoint(position=np.array([1.0, 2.0, -3.0]), yaw=0.5)])
    fields = written("POSITION_TARGET_LOCAL_NED", firmware)
    assert fields["type_mask"] == 0b1001_1111_1000 & ~0b10_0000_0000
    assert (fields["x"], fields["yaw"]) == (1.0, 0.5)


@pytest.mark.parametrize("value", [math.nan, math.inf, -math.inf, 1e30])
@pytest.mark.parametrize("message_id", sorted(PX4.writers))
def test_a_state_beyond_all_bounds_can_still_be_told(message_id: int, value: float) -> None:
    lost = FakeFirmware(
        position=np.full(3, value), velocity=np.full(3, value), battery=Battery(value, value, value)
    )
    frame = PX4.writers[message_id](report(lost, PX4, 1, 4, 1.0)).pack(mavlink.MAVLink(None, 1, 1))
    assert int.from_bytes(frame[7:10], "little") == message_id


def test_the_attitude_controllers_target_is_told() -> None:
    fields = written("ATTITUDE_TARGET")
    assert fields["q"] == pytest.approx([1.0, 0.0, 0.0, 0.0])
    assert (fields["body_roll_rate"], fields["thrust"]) == (pytest.approx(0.4), pytest.approx(0.45))


def test_rotors_idle_below_their_range_when_disarmed() -> None:
    assert written("SERVO_OUTPUT_RAW")["servo4_raw"] == 900
    flying = written("SERVO_OUTPUT_RAW", FakeFirmware(armed=True))
    assert (flying["servo4_raw"], flying["servo5_raw"]) == (1450, 900)


@pytest.mark.parametrize(("position_ok", "predicts"), [(True, True), (False, False)])
def test_the_estimators_flags_say_whether_there_is_a_position(position_ok: bool, predicts: bool) -> None:
    firmware = FakeFirmware(
        health=Health(sensors_ok=True, gps_ok=True, position_ok=position_ok, ready_to_arm=True)
    )
    flags = written("ESTIMATOR_STATUS", firmware)["flags"]
    assert bool(flags & mavlink.ESTIMATOR_PRED_POS_HORIZ_ABS) is predicts
    of_ardupilot = ekf_status_report(report(firmware, ARDUPILOT, 1, 4, 1.0)).to_dict()
    assert of_ardupilot["flags"] == flags  # the same bits in both messages


def test_the_date_does_not_depend_on_the_day() -> None:
    assert written("SYSTEM_TIME", time_s=2.0)["time_unix_usec"] == 1_767_225_602_000_000
