"""Each kind of fault does what it says to the frames between a vehicle and its companion."""

from collections.abc import Callable

import numpy as np
import pytest
from mavlink_fakes import FakeFirmware, encode, fake_vehicle, parse
from pymavlink.dialects.v20 import common as mavlink

from sitl.faults.reading import parse_fault
from sitl.firmware.interface import Mode
from sitl.mavlink import MavlinkVehicle
from sitl.mavlink.frames import decode


def broken(*faults: str) -> tuple[MavlinkVehicle, FakeFirmware]:
    """A vehicle of which these faults are there."""
    vehicle, firmware = fake_vehicle()
    for fault in faults:
        vehicle.simulation.faults.inject(parse_fault(fault))
    vehicle.simulation.faults.update(0.0, vehicle.simulation.firmware)
    return vehicle, firmware


def attitudes(vehicle: MavlinkVehicle) -> list[tuple[float, float]]:
    """When each ATTITUDE of the next second was sent, and when it arrives (s)."""
    start_s = vehicle.simulation.time_s
    return [
        (message.time_boot_ms * 1e-3, delivery.time_s)
        for delivery in vehicle.advance(start_s + 1.0)
        for message in decode(delivery.data)
        if isinstance(message, mavlink.MAVLink_attitude_message)
    ]


def setpoint(north: float) -> bytes:
    return encode(
        mavlink.MAVLink_set_position_target_local_ned_message(
            0, 1, 1, mavlink.MAV_FRAME_LOCAL_NED, 0b110111111000, north, 0, -2, 0, 0, 0, 0, 0, 0, 0, 0
        )
    )


def test_nothing_is_wrong_without_faults() -> None:
    times = attitudes(broken()[0])
    assert len(times) == 100
    assert all(sent_s == pytest.approx(arrives_s, abs=1e-3) for sent_s, arrives_s in times)


@pytest.mark.parametrize("fault", ["telemetry_lost", "link_lost", "telemetry_lossy:share=1"])
def test_nothing_arrives_from_the_vehicle(fault: str) -> None:
    assert not broken(fault)[0].advance(1.0)


@pytest.mark.parametrize("fault", ["uplink_lost", "link_lost", "uplink_lossy:share=1"])
def test_nothing_arrives_at_the_vehicle(fault: str) -> None:
    vehicle, firmware = broken(fault)
    vehicle.receive(setpoint(1.0))
    vehicle.advance(1.0)
    assert not firmware.setpoints


def test_what_is_sent_is_late() -> None:
    vehicle, firmware = broken("telemetry_late:delay_s=0.3", "uplink_late:delay_s=0.2")
    assert all(arrives_s - sent_s == pytest.approx(0.3) for sent_s, arrives_s in attitudes(vehicle))
    vehicle.receive(setpoint(1.0))
    vehicle.advance(1.19)
    assert not firmware.setpoints
    vehicle.advance(1.25)
    assert len(firmware.setpoints) == 1


@pytest.mark.parametrize(
    ("fault", "holds"),
    [
        ("telemetry_lossy:share=0.4", lambda times: 40 < len(times) < 80),
        ("telemetry_duplicated:share=0.4", lambda times: 120 < len(times) < 160),
        ("telemetry_reordered:share=0.2", lambda times: sorted(times) != times and len(times) == 100),
        ("telemetry_corrupted:share=0.4", lambda times: 40 < len(times) < 85),
        ("telemetry_late:delay_s=0.05,jitter_s=0.05", lambda times: sorted(times) != times),
    ],
)
def test_a_share_of_the_frames_suffers(
    fault: str, holds: Callable[[list[tuple[float, float]]], bool]
) -> None:
    assert holds(attitudes(broken(fault)[0]))


def test_a_frozen_state_has_times_that_go_on() -> None:
    vehicle, firmware = broken("telemetry_frozen:lasts_s=5")
    vehicle.advance(0.5)
    firmware.position = np.array([9.0, 9.0, -9.0])
    positions = [
        message for message in parse(vehicle.advance(1.0)) if message.get_type() == "LOCAL_POSITION_NED"
    ]
    assert {message.x for message in positions} == {1.0}
    assert positions[-1].time_boot_ms > 900
    vehicle.simulation.faults.update(5.0, vehicle.simulation.firmware)
    told = [message for message in parse(vehicle.advance(1.2)) if message.get_type() == "LOCAL_POSITION_NED"]
    assert {message.x for message in told} == {9.0}


def test_the_mode_is_told_though_the_state_is_frozen() -> None:
    vehicle, firmware = broken("telemetry_frozen")
    vehicle.advance(0.5)
    firmware.mode = Mode.LAND
    modes = [message for message in parse(vehicle.advance(2.0)) if message.get_type() == "HEARTBEAT"]
    assert modes[-1].custom_mode == 4 << 16 | 6 << 24


def test_one_message_stays_away() -> None:
    names = {
        message.get_type() for message in parse(broken("message_lost:message=HEARTBEAT")[0].advance(2.0))
    }
    assert "HEARTBEAT" not in names
    assert "ATTITUDE" in names


def test_a_clock_is_wrong() -> None:
    times = attitudes(broken("clock_jump:step_s=3")[0])
    assert all(told_s - arrives_s == pytest.approx(3.0, abs=2e-3) for told_s, arrives_s in times)


def test_a_setpoint_that_is_ignored_is_the_one_before() -> None:
    vehicle, firmware = fake_vehicle()
    vehicle.receive(setpoint(1.0))
    vehicle.simulation.faults.inject(parse_fault("setpoints_ignored"))
    vehicle.simulation.faults.update(0.0, vehicle.simulation.firmware)
    vehicle.receive(setpoint(2.0))
    assert [sent.position[0] for sent in firmware.setpoints] == [1.0, 1.0]
