"""Each kind of fault does what it says to a simulated vehicle that hovers."""

import math

import numpy as np
import pytest
from sitl_flights import BEBOP2, IDEAL, hover, in_hover, texts

from sitl.arrays import Vec3
from sitl.faults.disturbance import disturbance, gust_share
from sitl.faults.kinds import Gust
from sitl.faults.reading import parse_fault
from sitl.faults.schedule import Active
from sitl.firmware.interface import Mode, Result
from sitl.quaternion import yaw_of
from sitl.simulation import Simulation
from sitl.vehicle import load_vehicle

ARDUCOPTER = load_vehicle("arducopter_sitl")


def with_fault(text: str, seconds: float, sim: Simulation | None = None) -> Simulation:
    sim = sim or in_hover()
    sim.faults.inject(parse_fault(text))
    sim.advance(sim.time_s + seconds)
    return sim


def estimate_error(sim: Simulation) -> Vec3:
    error: Vec3 = sim.firmware.estimate.position - sim.truth.position
    return error


def farthest_m(sim: Simulation, since_s: float) -> float:
    positions = np.array([truth.position for truth in sim.truth_log if truth.time_s >= since_s])
    return float(np.linalg.norm(positions - positions[0], axis=1).max())


def test_a_flight_without_faults_is_the_same_to_the_bit() -> None:
    plain, later = in_hover(), hover(Simulation(BEBOP2, IDEAL, seed=1, faults=[Gust(at_s=1e4)]))
    assert np.array_equal(plain.truth.position, later.truth.position)
    assert np.array_equal(plain.truth.rates, later.truth.rates)


def test_a_weak_rotor_turns_with_what_is_left() -> None:
    sim = with_fault("motor_weak:motor=2,effectiveness=0.64", 3.0)
    assert farthest_m(sim, 15.0) > 0.1
    assert sim.truth.position[2] < -2.0
    assert sim._plant.effectiveness.tolist() == [1.0, 0.64, 1.0, 1.0]


def test_a_dead_rotor_brings_a_quadrotor_down() -> None:
    sim = with_fault("motor_dead:motor=1", 4.0)
    assert sim._plant.body.rotor_speed[0] == pytest.approx(0.0, abs=1e-6)
    assert sim.truth.position[2] == 0.0


def test_a_rotor_that_a_vehicle_does_not_have_cannot_fail() -> None:
    now = disturbance([Active(parse_fault("motor_dead:motor=7"), 0.0)], 1.0, rotors=4)
    assert now.effectiveness.tolist() == [1.0] * 4


def test_the_kill_switch_stops_all() -> None:
    sim = with_fault("rotors_stopped", 2.0)
    assert not sim.firmware.armed
    assert sim.truth.position[2] == 0.0


def test_a_gust_rises_stays_and_ends() -> None:
    gust = Gust(north_m_s=8.0, rise_s=0.5, lasts_s=2.0)
    assert [round(gust_share(gust, t), 3) for t in (0.0, 0.25, 0.5, 1.0, 1.75, 2.0)] == [0, 0.5, 1, 1, 0.5, 0]
    sim = with_fault("gust:north_m_s=8,lasts_s=2", 1.0)
    assert sim.truth.wind.tolist() == [8.0, 0.0, 0.0]
    sim.advance(sim.time_s + 1.1)
    assert sim.truth.wind.tolist() == [0.0, 0.0, 0.0]
    assert 0.2 < farthest_m(sim, 15.0) < 2.0


def test_a_battery_collapses_and_warns() -> None:
    sim = in_hover()
    sim.firmware.set_parameter("COM_LOW_BAT_ACT", 2)
    with_fault("battery_collapse:remaining=0.06", 0.1, sim)
    assert sim.firmware.battery.remaining < 0.061
    assert sim.firmware.mode is Mode.LAND
    assert "battery" in texts(sim)


@pytest.mark.parametrize(("announced", "resets"), [("true", 1), ("false", 0)])
def test_an_estimate_jumps_with_or_without_a_word(announced: str, resets: int) -> None:
    sim = with_fault(f"estimator_jump:north_m=2,east_m=-1,announced={announced}", 0.01)
    assert estimate_error(sim) == pytest.approx([2.0, -1.0, 0.0], abs=1e-9)
    assert sim.firmware.estimate.resets == resets


def test_an_estimate_drifts_and_takes_the_vehicle_along() -> None:
    sim = with_fault("estimator_drift:east_m_s=0.5", 4.0)
    assert estimate_error(sim)[1] == pytest.approx(2.0, abs=0.01)
    assert sim.truth.position[1] < -1.0


def test_a_velocity_is_wrong() -> None:
    sim = with_fault("velocity_error:north_m_s=0.5", 0.05)
    assert (sim.firmware.estimate.velocity - sim.truth.velocity)[0] == pytest.approx(0.5)


def test_gps_has_the_vehicle_where_it_is_however_its_estimate_drifts() -> None:
    sim = with_fault("estimator_drift:east_m_s=0.5", 4.0)
    assert estimate_error(sim)[1] == pytest.approx(2.0, abs=0.05)
    assert sim.firmware.estimate.gps == pytest.approx(sim.truth.position, abs=0.05)


def test_a_compass_error_turns_the_world_and_not_the_tilt() -> None:
    sim = in_hover()
    before = yaw_of(sim.firmware.estimate.attitude)
    with_fault("compass_error:error_deg=30", 0.01, sim)
    assert yaw_of(sim.firmware.estimate.attitude) - before == pytest.approx(math.radians(30.0), abs=0.01)
    assert sim.firmware.estimate.test_ratios[0] == pytest.approx(0.1)
    assert 0.5 < sim.firmware.estimate.test_ratios[1] < 1.0


def test_px4_without_satellites_reckons_on_and_then_descends_level() -> None:
    sim = with_fault("gps_lost:north_m_s2=0.1", 4.9)
    assert sim.firmware.position_ok
    assert not sim.firmware.health.gps_ok
    assert estimate_error(sim)[0] == pytest.approx(0.5 * 0.1 * 4.9**2, abs=0.05)
    sim.advance(sim.time_s + 0.3)
    assert (sim.firmware.position_ok, sim.firmware.mode) == (False, Mode.LAND)
    assert "position estimate lost" in texts(sim)
    sim.advance(sim.time_s + 10.0)
    assert sim.truth.position[2] == 0.0
    assert not sim.firmware.armed


def test_ardupilot_without_satellites_lands() -> None:
    sim = with_fault("gps_lost", 10.8, in_hover(ARDUCOPTER))
    assert not sim.firmware.failsafe
    sim.advance(sim.time_s + 0.5)
    assert sim.firmware.mode is Mode.LAND
    assert "EKF Failsafe" in texts(sim)


def test_ardupilot_lands_level_once_it_has_no_position() -> None:
    sim = with_fault("gps_lost", 9.0, in_hover(ARDUCOPTER))
    assert sim.firmware.set_mode(Mode.LAND) is Result.ACCEPTED
    sim.advance(sim.time_s + 1.8)
    assert np.isfinite(sim.firmware.active_setpoint.velocity).all()
    sim.advance(sim.time_s + 1.0)
    assert np.isnan(sim.firmware.active_setpoint.velocity[:2]).all()
    tilt = 2.0 * np.hypot(*sim.truth.attitude[1:3])
    assert tilt < np.radians(1.0)
    sim.advance(sim.time_s + 8.0)
    assert not sim.firmware.armed


def test_satellites_that_come_back_reset_the_estimate() -> None:
    sim = with_fault("gps_lost:lasts_s=3", 3.5)
    assert sim.firmware.health.gps_ok
    assert estimate_error(sim) == pytest.approx(np.zeros(3), abs=1e-9)
    assert sim.firmware.estimate.resets == 2  # when it is lost, by nothing; when it is back


def test_a_reboot_in_the_air_drops_the_vehicle() -> None:
    sim = with_fault("reboot", 2.0)
    assert not sim.firmware.armed
    assert sim.truth.position[2] == 0.0


def test_the_pilot_takes_a_mode_and_keeps_it() -> None:
    sim = with_fault("pilot_mode:mode=ALTCTL", 3.0)
    assert sim.firmware.mode is Mode.ALTCTL


@pytest.mark.parametrize("mode", ["POSCTL", "HOLD"])
def test_what_px4_calls_position_is_loiter_to_the_pilot_of_ardupilot(mode: str) -> None:
    sim = in_hover(ARDUCOPTER)
    assert sim.firmware.set_mode(Mode.OFFBOARD) is Result.ACCEPTED
    sim = with_fault(f"pilot_mode:mode={mode}", 3.0, sim)
    assert sim.firmware.mode is Mode.HOLD


def test_the_pilot_moves_the_sticks() -> None:
    sim = with_fault("pilot_sticks:pitch=0.5,lasts_s=2", 1.0)
    assert sim.firmware.mode is Mode.POSCTL
    assert sim.truth.velocity[0] > 0.5
