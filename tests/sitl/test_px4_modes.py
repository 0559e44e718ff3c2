import math

import numpy as np
import pytest
from sitl_flights import BEBOP2, in_hover, simulation, stream, texts, with_parameters

from sitl.arrays import Vec3
from sitl.firmware.interface import Landed, Mode, Result, Setpoint
from sitl.simulation import Simulation
from sitl.vehicle import Vehicle


def at(north: float, east: float, down: float) -> Vec3:
    return np.array((north, east, down))


HOVER_POINT = Setpoint(position=at(0.0, 0.0, -2.5), yaw=0.0)


def landed(sim: Simulation) -> Landed:
    return sim.firmware.landed


# Taking off and landing


def test_boots_on_the_ground_ready_to_arm() -> None:
    firmware = simulation().firmware
    assert not firmware.armed
    assert firmware.mode is Mode.HOLD
    assert firmware.landed is Landed.ON_GROUND
    assert firmware.health.ready_to_arm
    assert not firmware.failsafe


def test_takes_off_to_the_default_altitude_and_holds() -> None:
    sim = simulation()
    sim.firmware.takeoff()
    sim.firmware.arm()
    phases = set()
    while sim.time_s < 20.0:
        sim.advance(sim.time_s + 0.1)
        phases.add(sim.firmware.landed)
    assert phases == {Landed.ON_GROUND, Landed.TAKING_OFF, Landed.IN_AIR}
    assert sim.firmware.mode is Mode.HOLD
    assert sim.truth.position == pytest.approx((0.0, 0.0, -2.5), abs=0.05)
    assert min(truth.velocity[2] for truth in sim.truth_log) > -1.7  # MPC_TKO_SPEED
    assert "Takeoff detected" in texts(sim)


def test_takes_off_to_a_given_altitude() -> None:
    sim = simulation()
    sim.firmware.arm()
    sim.firmware.takeoff(6.0)
    sim.advance(20.0)
    assert sim.truth.position[2] == pytest.approx(-6.0, abs=0.1)


@pytest.mark.parametrize("altitude_m", [0.0, -1.0])
def test_a_takeoff_does_not_go_down(altitude_m: float) -> None:
    sim = in_hover()
    assert sim.firmware.takeoff(altitude_m) is Result.ACCEPTED
    assert ("Already higher" in texts(sim)) == (altitude_m < 0.0)
    sim.advance(sim.time_s + 3.0)
    assert sim.firmware.mode is Mode.HOLD
    assert sim.truth.position[2] == pytest.approx(-2.5, abs=0.1)


def test_a_takeoff_in_the_air_climbs_on() -> None:
    sim = in_hover()
    assert sim.firmware.takeoff() is Result.ACCEPTED
    assert "Using default takeoff altitude: 2.5 m" in texts(sim)
    sim.advance(sim.time_s + 8.0)
    assert sim.truth.position[2] == pytest.approx(-5.0, abs=0.2)


def test_lands_gently_and_disarms() -> None:
    sim = in_hover()
    sim.firmware.set_mode(Mode.LAND)
    assert landed(sim) is Landed.LANDING
    sim.advance(30.0)
    touchdown = max(truth.velocity[2] for truth in sim.truth_log[1500:])
    assert 0.6 < touchdown < 0.8  # MPC_LAND_SPEED
    assert not sim.firmware.armed
    assert landed(sim) is Landed.ON_GROUND
    assert "Landing detected" in texts(sim)
    assert sim.truth.position == pytest.approx((0.0, 0.0, 0.0), abs=0.05)


def test_flies_again_after_landing() -> None:
    sim = in_hover()
    sim.firmware.set_mode(Mode.LAND)
    sim.advance(30.0)
    assert sim.firmware.takeoff() is Result.ACCEPTED
    assert sim.firmware.arm() is Result.ACCEPTED
    sim.advance(45.0)
    assert sim.truth.position[2] == pytest.approx(-2.5, abs=0.1)


def test_returns_over_home_and_lands() -> None:
    sim = in_hover(with_parameters(RTL_RETURN_ALT=6.0))
    sim.firmware.reposition(at(12.0, -5.0, -2.5), math.nan)
    sim.advance(30.0)
    assert sim.truth.position == pytest.approx((12.0, -5.0, -2.5), abs=0.1)
    sim.firmware.set_mode(Mode.RTL)
    sim.advance(80.0)
    flown = np.array([truth.position for truth in sim.truth_log[3000:]])
    assert -flown[:, 2].min() == pytest.approx(6.0, abs=0.2)
    assert flown[-1] == pytest.approx((0.0, 0.0, 0.0), abs=0.2)
    assert not sim.firmware.armed


# Arming


def test_disarms_by_itself_when_nothing_happens() -> None:
    sim = simulation()
    sim.firmware.arm()
    sim.advance(9.5)
    assert "preflight" not in texts(sim)
    sim.advance(10.5)
    assert not sim.firmware.armed
    assert "preflight" in texts(sim)


def test_armed_rotors_idle_on_the_ground() -> None:
    sim = simulation()
    sim.firmware.arm()
    sim.advance(5.0)
    assert sim.firmware.armed
    assert (sim.truth.position == 0.0).all()


def test_disarming_in_the_air_needs_force() -> None:
    sim = in_hover()
    assert sim.firmware.disarm() is Result.TEMPORARILY_REJECTED
    assert "not landed" in texts(sim)
    assert sim.firmware.disarm(force=True) is Result.ACCEPTED
    sim.advance(sim.time_s + 3.0)
    assert sim.truth.position[2] == 0.0


@pytest.mark.parametrize("mode", [Mode.LAND, Mode.RTL])
def test_arming_is_refused_in_modes_that_do_not_take_off(mode: Mode) -> None:
    sim = simulation()
    sim.firmware.set_mode(mode)
    assert sim.firmware.arm() is Result.TEMPORARILY_REJECTED
    assert f"Arming denied: mode {mode.name}" in texts(sim)
    assert not sim.firmware.health.ready_to_arm
    assert sim.firmware.arm(force=True) is Result.ACCEPTED


def small_battery(**parameters: float) -> Vehicle:
    data = with_parameters(**parameters).model_dump(exclude_unset=True)
    return Vehicle.model_validate(data | {"battery": {"capacity_ah": 0.05}})


def test_arming_is_refused_with_a_low_battery() -> None:
    sim = in_hover(small_battery(BAT_LOW_THR=0.5))
    sim.firmware.set_mode(Mode.LAND)
    sim.advance(40.0)
    assert not sim.firmware.armed
    texts(sim)
    assert sim.firmware.arm() is Result.TEMPORARILY_REJECTED
    assert "low battery" in texts(sim)


def test_battery_drains_warns_and_ends_the_flight() -> None:
    sim = in_hover(small_battery(RTL_RETURN_ALT=3.0, COM_LOW_BAT_ACT=3))
    full = sim.firmware.battery
    assert full.current_a == pytest.approx(BEBOP2.hover_current_a, rel=0.2)
    said = ""
    while sim.firmware.armed and sim.time_s < 60.0:
        sim.advance(sim.time_s + 1.0)
        said += texts(sim) + "\n"
    assert "Low battery" in said
    assert "Failsafe: battery" in said
    assert not sim.firmware.armed
    assert sim.firmware.battery.voltage_v < full.voltage_v
    assert max(truth.velocity[2] for truth in sim.truth_log) < 1.6


def test_a_low_battery_is_told_of_where_nothing_else_is_asked_for() -> None:
    sim = in_hover(small_battery(BAT_CRIT_THR=0.45, BAT_LOW_THR=0.5))
    sim.advance(sim.time_s + 15.0)
    assert sim.firmware.mode is Mode.HOLD
    assert texts(sim).count("Low battery") == 2


# Offboard


def test_offboard_needs_a_fresh_setpoint() -> None:
    sim = in_hover()
    assert sim.firmware.set_mode(Mode.OFFBOARD) is Result.TEMPORARILY_REJECTED
    assert "no offboard setpoints" in texts(sim)
    sim.firmware.offboard_setpoint(Setpoint())
    assert sim.firmware.set_mode(Mode.OFFBOARD) is Result.TEMPORARILY_REJECTED
    sim.firmware.offboard_setpoint(HOVER_POINT)
    sim.advance(sim.time_s + 1.1)
    assert sim.firmware.set_mode(Mode.OFFBOARD) is Result.TEMPORARILY_REJECTED
    sim.firmware.offboard_setpoint(HOVER_POINT)
    sim.advance(sim.time_s + 0.9)
    assert sim.firmware.set_mode(Mode.OFFBOARD) is Result.ACCEPTED


def test_offboard_flies_to_its_setpoint() -> None:
    sim = in_hover()
    stream(sim, Setpoint(position=at(2.0, -1.0, -4.0), yaw=0.7), 12.0)
    assert sim.truth.position == pytest.approx((2.0, -1.0, -4.0), abs=0.05)
    assert 2.0 * math.atan2(sim.truth.attitude[3], sim.truth.attitude[0]) == pytest.approx(0.7, abs=0.01)


def test_offboard_velocity_without_position() -> None:
    sim = in_hover()
    stream(sim, Setpoint(velocity=at(1.0, 0.0, 0.0), yaw=0.0), 10.0)
    assert sim.truth.velocity == pytest.approx((1.0, 0.0, 0.0), abs=0.02)


def test_offboard_takes_off_with_the_ramp() -> None:
    sim = simulation()
    sim.firmware.offboard_setpoint(HOVER_POINT)
    assert sim.firmware.set_mode(Mode.OFFBOARD) is Result.ACCEPTED
    assert sim.firmware.arm() is Result.ACCEPTED
    stream(sim, HOVER_POINT, 2.0)
    assert sim.firmware.landed is Landed.ON_GROUND
    stream(sim, HOVER_POINT, 12.0)
    assert sim.truth.position == pytest.approx((0.0, 0.0, -2.5), abs=0.1)


def test_offboard_setpoint_on_the_ground_does_not_take_off() -> None:
    sim = simulation()
    sim.firmware.arm()
    stream(sim, Setpoint(position=at(1.0, 0.0, 0.5)), 5.0)
    assert (sim.truth.position == 0.0).all()


def test_arming_in_offboard_needs_setpoints() -> None:
    sim = simulation()
    stream(sim, HOVER_POINT, 0.1)
    sim.advance(3.0)
    assert sim.firmware.mode is Mode.OFFBOARD
    assert sim.firmware.arm() is Result.TEMPORARILY_REJECTED
    assert "Arming denied: no offboard setpoints" in texts(sim)


def lose_the_stream(action: int) -> Simulation:
    sim = in_hover(with_parameters(COM_OBL_RC_ACT=action, RTL_RETURN_ALT=3.0))
    stream(sim, Setpoint(velocity=at(1.0, 0.0, 0.0), yaw=0.0), 3.0)
    sim.advance(sim.time_s + 0.9)
    assert sim.firmware.mode is Mode.OFFBOARD
    assert not sim.firmware.failsafe
    sim.advance(sim.time_s + 0.2)
    return sim


@pytest.mark.parametrize(
    ("action", "mode"), [(0, Mode.POSCTL), (3, Mode.RTL), (4, Mode.LAND), (5, Mode.HOLD)]
)
def test_lost_setpoints_do_what_the_parameter_says(action: int, mode: Mode) -> None:
    sim = lose_the_stream(action)
    assert sim.firmware.mode is mode
    assert sim.firmware.failsafe
    assert "offboard setpoints lost" in texts(sim)


def test_after_lost_setpoints_the_vehicle_brakes_and_stays() -> None:
    sim = lose_the_stream(0)
    lost_at = sim.truth.position[0]
    sim.advance(sim.time_s + 8.0)
    stopped = sim.truth.position
    assert sim.truth.velocity == pytest.approx((0.0, 0.0, 0.0), abs=0.02)
    assert lost_at < stopped[0] < lost_at + 1.5
    sim.advance(sim.time_s + 10.0)
    assert sim.truth.position == pytest.approx(stopped, abs=0.05)


def test_offboard_resumes_with_the_stream() -> None:
    sim = lose_the_stream(0)
    sim.firmware.offboard_setpoint(HOVER_POINT)
    sim.advance(sim.time_s + 0.02)
    assert sim.firmware.mode is Mode.OFFBOARD
    assert not sim.firmware.failsafe


def test_offboard_does_not_resume_when_another_mode_was_chosen() -> None:
    sim = lose_the_stream(0)
    assert sim.firmware.set_mode(Mode.POSCTL) is Result.ACCEPTED
    assert not sim.firmware.failsafe
    sim.firmware.offboard_setpoint(HOVER_POINT)
    sim.advance(sim.time_s + 0.1)
    assert sim.firmware.mode is Mode.POSCTL


def test_unfinished_setpoints_stop_the_vehicle() -> None:
    sim = in_hover()
    stream(sim, Setpoint(velocity=at(1.0, 0.0, 0.0), yaw=0.0), 3.0)
    stream(sim, Setpoint(velocity=at(1.0, math.nan, 0.0), yaw=0.0), 5.0)
    assert sim.truth.velocity == pytest.approx((0.0, 0.0, 0.0), abs=0.05)


# Hold


def test_reposition_keeps_what_is_nan() -> None:
    sim = in_hover()
    assert sim.firmware.reposition(at(3.0, math.nan, math.nan), 1.0) is Result.ACCEPTED
    sim.advance(sim.time_s + 15.0)
    assert sim.firmware.mode is Mode.HOLD
    assert sim.truth.position == pytest.approx((3.0, 0.0, -2.5), abs=0.05)
    assert sim.firmware.active_setpoint.yaw == pytest.approx(1.0)
    assert sim.firmware.active_setpoint.position == pytest.approx((3.0, 0.0, -2.5), abs=0.01)


def test_reposition_on_the_ground_is_refused() -> None:
    sim = simulation()
    assert sim.firmware.reposition(at(1.0, 0.0, -2.0), 0.0) is Result.TEMPORARILY_REJECTED
    assert "not flying" in texts(sim)


def test_texts_are_taken_once() -> None:
    sim = simulation()
    sim.firmware.arm()
    assert "Armed" in texts(sim)
    assert texts(sim) == ""
