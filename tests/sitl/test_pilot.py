import math

import numpy as np
import pytest
from mavlink_fakes import BEBOP2, PEER_SYSTEM, answers, fake_vehicle
from pymavlink.dialects.v20 import common as mavlink
from sitl_flights import in_hover, stream, texts

from sitl.firmware.interface import Mode, Setpoint
from sitl.firmware.pilot import Sticks
from sitl.simulation import Simulation
from sitl.vehicle import Vehicle, load_vehicle

ARDUCOPTER = load_vehicle("arducopter_sitl")


def fly_by_sticks(sim: Simulation, sticks: Sticks, seconds: float) -> None:
    end_s = sim.time_s + seconds
    while sim.time_s < end_s - 1e-6:
        sim.firmware.move_sticks(sticks)
        sim.advance(sim.time_s + 0.05)


def test_sticks_ask_for_a_velocity_as_the_nose_points() -> None:
    velocity = Sticks(roll=0.5, pitch=1.0, climb=-1.0).velocity(math.pi / 2, 10.0, 3.0, 1.5)
    np.testing.assert_allclose(velocity, [-5.0, 10.0, 1.5], atol=1e-9)


@pytest.mark.parametrize("vehicle", [BEBOP2, ARDUCOPTER], ids=["px4", "ardupilot"])
def test_a_pilot_moves_the_vehicle_and_lets_go(vehicle: Vehicle) -> None:
    sim = in_hover(vehicle)
    before = sim.truth.position
    fly_by_sticks(sim, Sticks(pitch=0.4), 3.0)
    assert sim.truth.velocity[0] > 2.0
    fly_by_sticks(sim, Sticks(), 6.0)
    assert np.linalg.norm(sim.truth.velocity) < 0.2
    assert sim.truth.position[0] > before[0] + 5.0
    assert sim.truth.position[2] == pytest.approx(before[2], abs=0.3)


@pytest.mark.parametrize(("override", "mode"), [(1, Mode.OFFBOARD), (3, Mode.POSCTL)])
def test_sticks_end_offboard_where_they_may(override: int, mode: Mode) -> None:
    sim = in_hover()
    sim.firmware.set_parameter("COM_RC_OVERRIDE", override)
    setpoint = Setpoint(position=np.array((0.0, 0.0, -2.5)))
    stream(sim, setpoint, 0.2)
    sim.firmware.move_sticks(Sticks(roll=0.8))
    sim.advance(sim.time_s + 0.02)
    assert sim.firmware.mode is mode
    assert ("Pilot took over" in texts(sim)) == (mode is Mode.POSCTL)


def test_sticks_come_as_manual_control_or_as_pulses() -> None:
    vehicle, firmware = fake_vehicle()
    manual = mavlink.MAVLink_manual_control_message(1, 500, -250, 750, 1000, 0)
    pulses = mavlink.MAVLink_rc_channels_override_message(1, 1, 1375, 1250, 1750, 2000, 0, 0, 0, 0)
    answers(vehicle, manual, pulses)
    assert firmware.calls == [("move_sticks", Sticks(-0.25, 0.5, 0.5, 1.0))] * 2


@pytest.mark.parametrize(("own", "moves"), [(PEER_SYSTEM, True), (255, False)])
def test_only_its_own_ground_station_moves_the_sticks_of_ardupilot(own: int, moves: bool) -> None:
    flying, firmware = fake_vehicle(vehicle=ARDUCOPTER)
    firmware.set_parameter("SYSID_MYGCS", own)
    answers(flying, mavlink.MAVLink_manual_control_message(1, 500, 0, 500, 0, 0))
    answers(flying, mavlink.MAVLink_rc_channels_override_message(1, 1, 1600, *[0] * 7))
    assert len(firmware.calls) == 2 * moves


def test_released_channels_and_other_vehicles_are_left_alone() -> None:
    vehicle, firmware = fake_vehicle()
    released = mavlink.MAVLink_rc_channels_override_message(1, 1, *[0] * 8)
    other = mavlink.MAVLink_manual_control_message(2, 500, 0, 500, 0, 0)
    answers(vehicle, released, other)
    assert firmware.calls == []
