"""Flights of the whole simulator through its bytes, in virtual time."""

import math
from typing import Any

import numpy as np
import pytest
from mavlink_fakes import command_long, encode, parse
from pymavlink.dialects.v20 import common as mavlink

from sitl.geodesy import geodetic_from_ned
from sitl.mavlink import MavlinkVehicle, open_vehicle

NAN = math.nan
OFFBOARD_MODE = command_long(mavlink.MAV_CMD_DO_SET_MODE, 1, 6)
TAKEOFF = command_long(mavlink.MAV_CMD_NAV_TAKEOFF, 0, 0, 0, NAN, NAN, NAN, NAN)
ARM = command_long(mavlink.MAV_CMD_COMPONENT_ARM_DISARM, 1)
HOLD, LANDING, POSCTL = 4 << 16 | 3 << 24, 4 << 16 | 6 << 24, 3 << 16


class Peer:
    """Flies a vehicle through its bytes and keeps the newest message of each kind."""

    def __init__(self, vehicle: MavlinkVehicle) -> None:
        self.vehicle = vehicle
        self.latest: dict[str, Any] = {}
        self.texts: list[str] = []

    def wait(self, seconds: float) -> None:
        for message in parse(self.vehicle.advance(self.vehicle.simulation.time_s + seconds)):
            self.latest[message.get_type()] = message
            if message.get_type() == "STATUSTEXT":
                self.texts.append(message.text)

    def ask(self, command: Any) -> int:
        self.vehicle.receive(encode(command))
        self.wait(0.1)
        return int(self.latest["COMMAND_ACK"].result)

    def hold_at(self, place: tuple[float, float, float], seconds: float) -> None:
        values = (*place, *[0.0] * 8)
        setpoint = mavlink.MAVLink_set_position_target_local_ned_message(
            0, 1, 1, mavlink.MAV_FRAME_LOCAL_NED, 0b1101_1111_1000, *values
        )
        for _ in range(round(seconds * 20)):
            self.vehicle.receive(encode(setpoint))
            self.wait(0.05)

    @property
    def position(self) -> tuple[float, float, float]:
        state = self.latest["LOCAL_POSITION_NED"]
        return state.x, state.y, state.z

    @property
    def mode(self) -> int:
        self.wait(1.0)
        return int(self.latest["HEARTBEAT"].custom_mode)


@pytest.fixture
def flying() -> Peer:
    peer = Peer(open_vehicle("bebop2", "realistic", seed=1))
    peer.wait(1.0)
    assert (peer.ask(ARM), peer.ask(TAKEOFF)) == (0, 0)
    peer.wait(12.0)
    assert peer.latest["EXTENDED_SYS_STATE"].landed_state == mavlink.MAV_LANDED_STATE_IN_AIR
    return peer


def test_offboard_follows_setpoints_and_falls_back_when_they_stop(flying: Peer) -> None:
    assert flying.ask(OFFBOARD_MODE) == mavlink.MAV_RESULT_TEMPORARILY_REJECTED
    assert any("no offboard set" in text for text in flying.texts)  # the rest is in another chunk
    place = (2.0, -1.0, -4.0)
    flying.hold_at(place, 1.0)
    assert flying.ask(OFFBOARD_MODE) == mavlink.MAV_RESULT_ACCEPTED
    flying.hold_at(place, 12.0)
    assert math.dist(flying.position, place) < 0.4
    assert flying.latest["POSITION_TARGET_LOCAL_NED"].x == 2.0
    flying.wait(2.0)
    assert flying.mode == POSCTL
    assert flying.latest["HEARTBEAT"].system_status == mavlink.MAV_STATE_CRITICAL


def test_reposition_flies_to_a_place_on_the_map(flying: Peer) -> None:
    place = geodetic_from_ned(3.0, 3.0, 0.0)
    frame = mavlink.MAV_FRAME_GLOBAL_RELATIVE_ALT_INT
    x, y = round(place.latitude_deg * 1e7), round(place.longitude_deg * 1e7)
    go = mavlink.MAVLink_command_int_message(
        1, 1, frame, mavlink.MAV_CMD_DO_REPOSITION, 0, 0, -1.0, 1.0, 0.0, NAN, x, y, 5.0
    )
    assert flying.ask(go) == mavlink.MAV_RESULT_ACCEPTED
    flying.wait(15.0)
    assert math.dist(flying.position, (3.0, 3.0, -5.0)) < 0.4
    assert flying.mode == HOLD


def test_landing_ends_disarmed_on_the_ground(flying: Peer) -> None:
    assert flying.ask(command_long(mavlink.MAV_CMD_COMPONENT_ARM_DISARM, 0)) == 1
    assert flying.ask(command_long(mavlink.MAV_CMD_NAV_LAND, 0, 0, 0, NAN)) == 0
    assert flying.mode == LANDING
    flying.wait(20.0)
    assert flying.latest["EXTENDED_SYS_STATE"].landed_state == mavlink.MAV_LANDED_STATE_ON_GROUND
    assert not flying.latest["HEARTBEAT"].base_mode & mavlink.MAV_MODE_FLAG_SAFETY_ARMED


def test_one_seed_is_one_flight_to_the_last_byte() -> None:
    def flight(seed: int) -> list[tuple[float, bytes]]:
        vehicle = open_vehicle("bebop2", "realistic", seed=seed)
        vehicle.receive(encode(ARM) + encode(TAKEOFF))
        return [(delivery.time_s, delivery.data) for delivery in vehicle.advance(5.0)]

    assert flight(7) == flight(7)
    assert flight(7) != flight(8)


def test_telemetry_tells_the_estimate_and_the_truth_stays_behind() -> None:
    vehicle = open_vehicle("bebop2", "realistic", seed=2, record_truth=True)
    told = [m for m in parse(vehicle.advance(20.0)) if m.get_type() == "LOCAL_POSITION_NED"]
    heights = np.array([message.z for message in told])
    assert 0.003 < heights.std() < 0.03
    assert len(vehicle.simulation.truth_log) == 2000


@pytest.mark.parametrize("value", [NAN, math.inf, 3.4e38, -3.4e38, 0.0])
def test_no_number_in_a_command_or_setpoint_brings_the_vehicle_down(flying: Peer, value: float) -> None:
    frames = (mavlink.MAV_FRAME_LOCAL_NED, mavlink.MAV_FRAME_BODY_NED)
    flying.hold_at((0.0, 0.0, -3.0), 0.2)
    for frame in frames:
        values = [value] * 11
        flying.vehicle.receive(
            encode(mavlink.MAVLink_set_position_target_local_ned_message(0, 1, 1, frame, 0, *values))
        )
    flying.ask(OFFBOARD_MODE)
    flying.ask(command_long(mavlink.MAV_CMD_DO_REPOSITION, value, 1.0, value, value, value, value, value))
    flying.ask(command_long(mavlink.MAV_CMD_NAV_TAKEOFF, *[value] * 7))
    flying.wait(3.0)
    assert all(map(math.isfinite, flying.position))
    assert flying.latest["EXTENDED_SYS_STATE"].landed_state == mavlink.MAV_LANDED_STATE_IN_AIR
