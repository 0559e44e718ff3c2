"""MAV_CMD_INJECT_FAILURE as PX4 answers it."""

import pytest
from mavlink_fakes import ARDUCOPTER, answers, command_long, fake_vehicle
from pymavlink.dialects.v20 import common as mavlink

from sitl.mavlink import MavlinkVehicle

ACCEPTED, DENIED, UNSUPPORTED = (
    mavlink.MAV_RESULT_ACCEPTED,
    mavlink.MAV_RESULT_DENIED,
    mavlink.MAV_RESULT_UNSUPPORTED,
)
MOTOR, GPS, MAG = (
    mavlink.FAILURE_UNIT_SYSTEM_MOTOR,
    mavlink.FAILURE_UNIT_SENSOR_GPS,
    mavlink.FAILURE_UNIT_SENSOR_MAG,
)
BATTERY, MAVLINK = mavlink.FAILURE_UNIT_SYSTEM_BATTERY, mavlink.FAILURE_UNIT_SYSTEM_MAVLINK_SIGNAL
OK, OFF, STUCK, WRONG = (
    mavlink.FAILURE_TYPE_OK,
    mavlink.FAILURE_TYPE_OFF,
    mavlink.FAILURE_TYPE_STUCK,
    mavlink.FAILURE_TYPE_WRONG,
)


def allowing() -> MavlinkVehicle:
    vehicle, firmware = fake_vehicle()
    firmware.set_parameter("SYS_FAILURE_EN", 1)
    return vehicle


def inject(vehicle: MavlinkVehicle, unit: int, type_: int, instance: int = 0) -> int:
    command = command_long(mavlink.MAV_CMD_INJECT_FAILURE, unit, type_, instance)
    (acknowledgement,) = answers(vehicle, command)
    vehicle.simulation.faults.update(vehicle.simulation.time_s, vehicle.simulation.firmware)
    result: int = acknowledgement.result
    return result


def kinds(vehicle: MavlinkVehicle) -> list[str]:
    return [each.fault.kind for each in vehicle.simulation.faults.active]


def test_it_is_denied_unless_a_parameter_allows_it() -> None:
    vehicle, _ = fake_vehicle()
    assert inject(vehicle, GPS, OFF) == DENIED
    assert kinds(vehicle) == []


def test_ardupilot_does_not_know_it() -> None:
    assert inject(fake_vehicle(vehicle=ARDUCOPTER)[0], MOTOR, OFF, 1) == UNSUPPORTED


@pytest.mark.parametrize(
    ("unit", "type_", "expected"),
    [
        (GPS, OFF, ["gps_lost"]),
        (GPS, STUCK, ["gps_lost"]),
        (GPS, WRONG, ["gps_lost"]),
        (MAG, WRONG, ["compass_error"]),
        (BATTERY, OFF, ["battery_collapse"]),
        (MOTOR, OFF, ["motor_dead"] * 4),
    ],
)
def test_a_unit_fails_and_is_well_again(unit: int, type_: int, expected: list[str]) -> None:
    vehicle = allowing()
    assert inject(vehicle, unit, type_) == ACCEPTED
    assert kinds(vehicle) == expected
    assert inject(vehicle, unit, OK) == ACCEPTED
    assert kinds(vehicle) == []


def test_the_link_fails_once_the_answer_is_sent() -> None:
    vehicle = allowing()
    assert inject(vehicle, MAVLINK, OFF) == ACCEPTED
    assert vehicle.advance(vehicle.simulation.time_s + 1.0) == []


def test_one_motor_of_several() -> None:
    vehicle = allowing()
    assert inject(vehicle, MOTOR, OFF, 2) == ACCEPTED
    assert inject(vehicle, MOTOR, OFF, 3) == ACCEPTED
    assert inject(vehicle, MOTOR, OK, 2) == ACCEPTED
    (left,) = vehicle.simulation.faults.active
    assert left.fault.model_dump()["motor"] == 3


def test_the_same_failure_twice_is_one() -> None:
    vehicle = allowing()
    assert [inject(vehicle, GPS, OFF), inject(vehicle, GPS, OFF)] == [ACCEPTED, ACCEPTED]
    assert kinds(vehicle) == ["gps_lost"]


@pytest.mark.parametrize(
    ("unit", "type_", "instance"),
    [
        (MOTOR, OFF, 5),
        (MOTOR, STUCK, 1),
        (GPS, OFF, 2),
        (mavlink.FAILURE_UNIT_SENSOR_AIRSPEED, OFF, 0),
        (mavlink.FAILURE_UNIT_SENSOR_AIRSPEED, OK, 0),
        (99, 99, 0),
    ],
)
def test_what_nothing_here_can_do_is_unsupported(unit: int, type_: int, instance: int) -> None:
    vehicle = allowing()
    assert inject(vehicle, unit, type_, instance) == UNSUPPORTED
    assert kinds(vehicle) == []
