"""Reboots, terminations, checks, the ground station's heartbeat, the origin: about the autopilot itself."""

import pytest
from mavlink_fakes import ARDUCOPTER, BEBOP2, answers, command_long, encode, fake_vehicle, parse
from pymavlink.dialects.v20 import common as mavlink

from sitl.firmware.interface import Mode, Result
from sitl.mavlink import MavlinkVehicle, open_vehicle
from sitl.plan.items import Item, PlanKind
from sitl.vehicle import Vehicle

ACCEPTED, DENIED, FAILED = mavlink.MAV_RESULT_ACCEPTED, mavlink.MAV_RESULT_DENIED, mavlink.MAV_RESULT_FAILED
REBOOT = command_long(mavlink.MAV_CMD_PREFLIGHT_REBOOT_SHUTDOWN, 1.0)
BOTH = pytest.mark.parametrize("vehicle", [BEBOP2, ARDUCOPTER], ids=["px4", "ardupilot"])


def result(vehicle: Vehicle, command: int, *params: float, armed: bool = False) -> tuple[int, list[object]]:
    flying, firmware = fake_vehicle(vehicle=vehicle)
    firmware.armed = armed
    *_, acknowledgement = answers(flying, command_long(command, *params))
    return acknowledgement.result, list(firmware.calls)


def told(vehicle: MavlinkVehicle, seconds: float) -> dict[str, list[object]]:
    messages: dict[str, list[object]] = {}
    for message in parse(vehicle.advance(vehicle.simulation.time_s + seconds)):
        messages.setdefault(message.get_type(), []).append(message)
    return messages


@BOTH
def test_termination_is_asked_of_the_firmware(vehicle: Vehicle) -> None:
    command = mavlink.MAV_CMD_DO_FLIGHTTERMINATION
    assert result(vehicle, command, 1.0, armed=True) == (ACCEPTED, [("terminate",)])
    assert result(vehicle, command, 0.0) == (DENIED, [])


@BOTH
def test_checks_are_run(vehicle: Vehicle) -> None:
    assert result(vehicle, mavlink.MAV_CMD_RUN_PREARM_CHECKS) == (ACCEPTED, [("check",)])


@pytest.mark.parametrize(("enabled", "expected"), [(0, DENIED), (1, mavlink.MAV_RESULT_UNSUPPORTED)])
def test_failures_are_denied_unless_they_are_allowed(enabled: int, expected: int) -> None:
    vehicle, firmware = fake_vehicle()
    firmware.set_parameter("SYS_FAILURE_EN", enabled)
    (acknowledgement,) = answers(vehicle, command_long(mavlink.MAV_CMD_INJECT_FAILURE))
    assert acknowledgement.result == expected


def test_only_ground_stations_are_heard() -> None:
    vehicle, firmware = fake_vehicle()
    for kind in (mavlink.MAV_TYPE_ONBOARD_CONTROLLER, mavlink.MAV_TYPE_GCS):
        heartbeat = mavlink.MAVLink_heartbeat_message(kind, mavlink.MAV_AUTOPILOT_INVALID, 0, 0, 4, 3)
        vehicle.receive(encode(heartbeat, 255, 190))
    vehicle.advance(0.01)
    assert firmware.calls == [("hear_ground_station", 255)]


def test_who_sets_the_origin_is_told_where_it_is() -> None:
    vehicle, _ = fake_vehicle()
    (origin,) = answers(vehicle, mavlink.MAVLink_set_gps_global_origin_message(1, 1, 2, 3))
    assert (origin.get_type(), origin.latitude) == ("GPS_GLOBAL_ORIGIN", 473977420)


@pytest.mark.parametrize(("vehicle", "refused"), [(BEBOP2, DENIED), (ARDUCOPTER, FAILED)])
def test_an_armed_vehicle_does_not_reboot(vehicle: Vehicle, refused: int) -> None:
    assert result(vehicle, mavlink.MAV_CMD_PREFLIGHT_REBOOT_SHUTDOWN, 1.0, armed=True)[0] == refused
    assert result(vehicle, mavlink.MAV_CMD_PREFLIGHT_REBOOT_SHUTDOWN, 0.0, armed=True)[0] == ACCEPTED


def test_a_reboot_keeps_parameters_and_plans_and_forgets_the_rest() -> None:
    vehicle = open_vehicle("bebop2")
    firmware = vehicle.simulation.firmware
    firmware.set_parameter("MIS_TAKEOFF_ALT", 7.0)
    firmware.plans.replace(PlanKind.MISSION, (Item(16, 3),))
    assert firmware.set_mode(Mode.POSCTL) is Result.ACCEPTED
    vehicle.receive(encode(command_long(mavlink.MAV_CMD_SET_MESSAGE_INTERVAL, 32.0, -1.0)))
    assert "LOCAL_POSITION_NED" not in told(vehicle, 5.0)
    vehicle.receive(encode(REBOOT))
    messages = told(vehicle, 1.0)
    positions: list[object] = messages["LOCAL_POSITION_NED"]
    assert positions[-1].time_boot_ms <= 1000  # type: ignore[attr-defined]
    after = vehicle.simulation.firmware
    assert after.parameters == firmware.parameters
    assert after.plans[PlanKind.MISSION] == firmware.plans[PlanKind.MISSION]
    assert after.mode is Mode.HOLD


@pytest.mark.parametrize(
    ("name", "parameter"), [("bebop2", "MAV_SYS_ID"), ("arducopter_sitl", "SYSID_THISMAV")]
)
def test_another_system_id_counts_from_the_next_boot_on(name: str, parameter: str) -> None:
    vehicle = open_vehicle(name, system_id=3)
    assert getattr(vehicle.simulation.firmware.parameters, parameter) == 3
    vehicle.simulation.firmware.set_parameter(parameter, 9)
    assert {delivery.data[5] for delivery in vehicle.advance(2.0)} == {3}
    vehicle.reboot()
    assert {delivery.data[5] for delivery in vehicle.advance(4.0)} == {9}


def test_a_reboot_in_flight_stops_the_rotors() -> None:
    vehicle = open_vehicle("bebop2")
    assert vehicle.simulation.firmware.arm() is Result.ACCEPTED
    vehicle.reboot()
    assert not vehicle.simulation.firmware.armed


@pytest.mark.parametrize(("name", "text"), [("bebop2", "system health"), ("arducopter_sitl", "Position")])
def test_a_vehicle_that_boots_has_no_position_and_does_not_arm(name: str, text: str) -> None:
    vehicle = open_vehicle(name, boot_time_s=20.0)
    vehicle.advance(1.0)
    vehicle.receive(encode(command_long(mavlink.MAV_CMD_SET_MESSAGE_INTERVAL, 32.0, 100_000.0)))
    vehicle.receive(encode(command_long(mavlink.MAV_CMD_COMPONENT_ARM_DISARM, 1.0)))
    messages = told(vehicle, 18.0)
    assert "LOCAL_POSITION_NED" not in messages
    assert any(text in message.text for message in messages["STATUSTEXT"])  # type: ignore[attr-defined]
    assert messages["COMMAND_ACK"][-1].result != ACCEPTED  # type: ignore[attr-defined]
    assert "LOCAL_POSITION_NED" in told(vehicle, 2.0)
    assert vehicle.simulation.firmware.arm() is Result.ACCEPTED
