import math

import numpy as np
import pytest
from sitl_flights import simulation, stream, texts, tilt_deg

from sitl.arrays import Vec3
from sitl.conditions import Conditions
from sitl.estimator_errors import EstimatorErrors
from sitl.firmware.interface import Landed, Mode, Result, Setpoint
from sitl.quaternion import yaw_of
from sitl.simulation import Simulation
from sitl.vehicle import Vehicle, load_vehicle

SITL = load_vehicle("arducopter_sitl")


def at(north: float, east: float, down: float) -> Vec3:
    return np.array((north, east, down))


def with_parameters(**parameters: float) -> Vehicle:
    data = SITL.model_dump(exclude_unset=True)
    own = SITL.ardupilot_parameters.model_dump(exclude_unset=True)
    return Vehicle.model_validate(data | {"ardupilot_parameters": own | parameters})


def landed(sim: Simulation) -> Landed:
    return sim.firmware.landed


def mode_of(sim: Simulation) -> Mode:
    return sim.firmware.mode


def armed(vehicle: Vehicle = SITL) -> Simulation:
    sim = simulation(vehicle)
    assert sim.firmware.set_mode(Mode.OFFBOARD) is Result.ACCEPTED
    assert sim.firmware.arm() is Result.ACCEPTED
    return sim


def in_guided(vehicle: Vehicle = SITL) -> Simulation:
    """In GUIDED, 5 m above the ground."""
    sim = armed(vehicle)
    assert sim.firmware.takeoff(5.0) is Result.ACCEPTED
    sim.advance(12.0)
    return sim


# Taking off and landing


def test_boots_in_stabilize_on_the_ground_ready_to_arm() -> None:
    firmware = simulation(SITL).firmware
    assert firmware.mode is Mode.STABILIZE
    assert firmware.landed is Landed.ON_GROUND
    assert firmware.health.ready_to_arm
    assert not firmware.armed
    assert not firmware.failsafe


def test_takes_off_in_guided_and_stays_there() -> None:
    sim = armed()
    assert sim.firmware.takeoff(5.0) is Result.ACCEPTED
    phases = set()
    while sim.time_s < 12.0:
        sim.advance(sim.time_s + 0.1)
        phases.add(landed(sim))
    assert phases == {Landed.ON_GROUND, Landed.TAKING_OFF, Landed.IN_AIR}
    assert mode_of(sim) is Mode.OFFBOARD
    assert sim.truth.position == pytest.approx((0.0, 0.0, -5.0), abs=0.02)
    assert min(truth.velocity[2] for truth in sim.truth_log) > -2.5  # WPNAV_SPEED_UP


def test_takeoff_is_refused_elsewhere_than_armed_in_guided_on_the_ground() -> None:
    sim = simulation(SITL)
    assert sim.firmware.takeoff(5.0) is Result.FAILED  # STABILIZE
    sim.firmware.set_mode(Mode.OFFBOARD)
    assert sim.firmware.takeoff(5.0) is Result.FAILED  # not armed
    sim.firmware.arm()
    for altitude_m in (None, 0.0, -1.0, math.nan):
        assert sim.firmware.takeoff(altitude_m) is Result.FAILED
    sim.firmware.takeoff(5.0)
    sim.advance(5.0)
    assert sim.firmware.takeoff(8.0) is Result.FAILED  # in the air


def test_a_setpoint_on_the_ground_does_not_take_off() -> None:
    sim = armed()
    stream(sim, Setpoint(position=at(0.0, 0.0, -5.0)), 5.0)
    assert (sim.truth.position == 0.0).all()
    assert landed(sim) is Landed.ON_GROUND


def test_a_setpoint_ends_a_takeoff() -> None:
    sim = armed()
    sim.firmware.takeoff(5.0)
    sim.advance(3.0)
    assert landed(sim) is Landed.TAKING_OFF
    stream(sim, Setpoint(position=at(0.0, 0.0, -3.0)), 8.0)
    assert sim.truth.position == pytest.approx((0.0, 0.0, -3.0), abs=0.05)
    early = armed()
    early.firmware.takeoff(5.0)
    stream(early, Setpoint(position=at(0.0, 0.0, -3.0)), 5.0)
    assert landed(early) is Landed.ON_GROUND


def test_lands_gently_disarms_and_flies_again() -> None:
    sim = in_guided()
    sim.firmware.set_mode(Mode.LAND)
    sim.advance(13.0)
    assert landed(sim) is Landed.LANDING
    sim.advance(30.0)
    assert max(truth.velocity[2] for truth in sim.truth_log[1800:]) == pytest.approx(0.5, abs=0.05)
    assert not sim.firmware.armed
    assert landed(sim) is Landed.ON_GROUND
    sim.firmware.set_mode(Mode.OFFBOARD)
    sim.firmware.arm()
    assert sim.firmware.takeoff(2.0) is Result.ACCEPTED
    sim.advance(45.0)
    assert sim.truth.position[2] == pytest.approx(-2.0, abs=0.05)


def test_returns_over_home_and_lands() -> None:
    sim = in_guided(with_parameters(RTL_ALT=800.0))
    sim.firmware.reposition(at(12.0, -5.0, -5.0), math.nan)
    sim.advance(25.0)
    sim.firmware.set_mode(Mode.RTL)
    sim.advance(80.0)
    flown = np.array([truth.position for truth in sim.truth_log[2500:]])
    assert -flown[:, 2].min() == pytest.approx(8.0, abs=0.3)
    assert flown[-1] == pytest.approx((0.0, 0.0, 0.0), abs=0.3)
    assert not sim.firmware.armed


# Arming


def test_arms_in_guided_loiter_and_stabilize_only() -> None:
    for mode in (Mode.OFFBOARD, Mode.HOLD, Mode.STABILIZE):
        sim = simulation(SITL)
        sim.firmware.set_mode(mode)
        assert sim.firmware.arm() is Result.ACCEPTED
    for mode in (Mode.LAND, Mode.RTL, Mode.BRAKE):
        sim = simulation(SITL)
        sim.firmware.set_mode(mode)
        assert not sim.firmware.health.ready_to_arm
        assert sim.firmware.arm() is Result.FAILED
        assert f"Arm: {mode.name} mode not armable" in texts(sim)
        assert sim.firmware.arm(force=True) is Result.ACCEPTED


def test_disarms_by_itself_on_the_ground() -> None:
    sim = armed()
    sim.advance(9.9)
    assert "Disarming motors" not in texts(sim)
    sim.advance(10.1)  # DISARM_DELAY
    assert not sim.firmware.armed
    assert "Disarming motors" in texts(sim)


def test_disarming_in_the_air_needs_force() -> None:
    sim = in_guided()
    assert sim.firmware.disarm() is Result.FAILED
    assert sim.firmware.disarm(force=True) is Result.ACCEPTED
    sim.advance(16.0)
    assert sim.truth.position[2] == 0.0


# GUIDED


def test_guided_flies_to_a_place_and_turns() -> None:
    sim = in_guided()
    stream(sim, Setpoint(position=at(2.0, -1.0, -4.0), yaw=0.7), 10.0)
    assert sim.truth.position == pytest.approx((2.0, -1.0, -4.0), abs=0.02)
    assert yaw_of(sim.truth.attitude) == pytest.approx(0.7, abs=0.03)


def test_guided_follows_position_velocity_and_acceleration() -> None:
    sim = in_guided()
    while sim.time_s < 32.0:
        phase = 0.8 * (sim.time_s - 12.0)
        circle = at(math.sin(phase), 1.0 - math.cos(phase), 0.0)
        sim.firmware.offboard_setpoint(
            Setpoint(
                position=circle - at(0.0, 0.0, 5.0),
                velocity=0.8 * at(math.cos(phase), math.sin(phase), 0.0),
                acceleration=0.64 * at(-math.sin(phase), math.cos(phase), 0.0),
                yaw=0.0,
            )
        )
        sim.advance(sim.time_s + 0.02)
    assert np.linalg.norm(sim.truth.position - circle + at(0.0, 0.0, 5.0)) < 0.05


def test_guided_looks_ahead_when_nobody_tells_it_where_to_look() -> None:
    sim = in_guided()
    stream(sim, Setpoint(velocity=at(0.0, 2.0, 0.0)), 12.0)
    assert yaw_of(sim.truth.attitude) == pytest.approx(0.5 * math.pi, abs=0.05)
    stream(sim, Setpoint(velocity=at(0.0, 2.0, 0.0), yaw_rate=0.3), 8.0)
    assert sim.truth.rates[2] == pytest.approx(0.3, abs=0.02)


@pytest.mark.parametrize("timeout_s", [1.0, 3.0])
def test_a_velocity_is_flown_until_its_timeout(timeout_s: float) -> None:
    sim = in_guided(with_parameters(GUID_TIMEOUT=timeout_s))
    stream(sim, Setpoint(velocity=at(1.0, 0.0, 0.0), yaw=0.0), 4.0)
    sim.advance(sim.time_s + timeout_s - 0.1)
    assert sim.truth.velocity == pytest.approx((1.0, 0.0, 0.0), abs=0.03)
    sim.advance(sim.time_s + 5.0)
    assert sim.truth.velocity == pytest.approx((0.0, 0.0, 0.0), abs=0.03)
    assert mode_of(sim) is Mode.OFFBOARD
    assert not sim.firmware.failsafe


def test_a_place_stays_a_target_without_setpoints() -> None:
    sim = in_guided()
    sim.firmware.offboard_setpoint(Setpoint(position=at(10.0, 0.0, -5.0)))
    sim.advance(sim.time_s + 15.0)
    assert sim.truth.position == pytest.approx((10.0, 0.0, -5.0), abs=0.02)


def test_entering_guided_stops_and_older_setpoints_do_not_count() -> None:
    sim = in_guided()
    stream(sim, Setpoint(velocity=at(2.0, 0.0, 0.0), yaw=0.0), 4.0)
    sim.firmware.set_mode(Mode.BRAKE)
    sim.firmware.offboard_setpoint(Setpoint(position=at(50.0, 0.0, -5.0)))
    sim.advance(sim.time_s + 8.0)
    stopped = sim.truth.position
    assert sim.truth.velocity == pytest.approx((0.0, 0.0, 0.0), abs=0.02)
    sim.firmware.set_mode(Mode.OFFBOARD)
    sim.advance(sim.time_s + 4.0)
    assert sim.truth.position == pytest.approx(stopped, abs=0.05)


def test_reposition_enters_guided_and_keeps_what_is_nan() -> None:
    sim = in_guided()
    sim.firmware.set_mode(Mode.HOLD)
    assert sim.firmware.reposition(at(3.0, math.nan, math.nan), 1.0) is Result.ACCEPTED
    assert mode_of(sim) is Mode.OFFBOARD
    sim.advance(sim.time_s + 10.0)
    assert sim.truth.position == pytest.approx((3.0, 0.0, -5.0), abs=0.05)
    assert yaw_of(sim.truth.attitude) == pytest.approx(1.0, abs=0.02)


def test_lean_stays_below_its_limit() -> None:
    sim = in_guided(with_parameters(PSC_ANGLE_MAX=12.0, WPNAV_ACCEL=500.0, PSC_JERK_XY=20.0))
    sim.firmware.offboard_setpoint(Setpoint(position=at(60.0, 0.0, -5.0)))
    sim.advance(sim.time_s + 20.0)
    assert 11.0 < max(tilt_deg(truth.attitude) for truth in sim.truth_log) < 14.0
    assert sim.truth.position == pytest.approx((60.0, 0.0, -5.0), abs=0.3)


# Modes and failsafes


def small_battery(**parameters: float) -> Vehicle:
    """Falls below BATT_LOW_VOLT half a minute after the start."""
    data = with_parameters(**parameters).model_dump(exclude_unset=True)
    battery = {"full_voltage_v": 12.6, "empty_voltage_v": 9.0, "capacity_ah": 0.3}
    return Vehicle.model_validate(data | {"battery": battery})


def test_modes_that_cannot_be_flown_are_refused() -> None:
    sim = in_guided()
    for mode in (Mode.STABILIZE, Mode.ALTCTL, Mode.TAKEOFF):
        assert sim.firmware.set_mode(mode) is Result.FAILED
    assert "Mode change to STABILIZE failed: no pilot" in texts(sim)
    assert mode_of(sim) is Mode.OFFBOARD


@pytest.mark.parametrize(("action", "mode"), [(0, Mode.OFFBOARD), (1, Mode.LAND), (2, Mode.RTL)])
def test_a_low_battery_does_what_the_parameter_says(action: int, mode: Mode) -> None:
    sim = in_guided(small_battery(BATT_FS_LOW_ACT=action, BATT_LOW_TIMER=2.0))
    while sim.firmware.battery.voltage_v >= 10.5:
        sim.advance(sim.time_s + 0.01)
    sim.advance(sim.time_s + 1.9)
    assert mode_of(sim) is Mode.OFFBOARD
    assert "low" not in texts(sim)
    sim.advance(sim.time_s + 0.2)
    assert mode_of(sim) is mode
    assert sim.firmware.failsafe is (action != 0)
    assert "Battery 1 is low" in texts(sim)


def test_begins_in_flight_where_it_is_told() -> None:
    motion = np.zeros(13)
    motion[:6] = 1.0, 2.0, -30.0, 1.5, 0.0, 0.0
    motion[6] = 1.0
    sim = Simulation(SITL, Conditions(name="ideal"), seed=0, motion=motion)
    assert sim.firmware.armed
    assert mode_of(sim) is Mode.OFFBOARD
    assert landed(sim) is Landed.IN_AIR
    sim.advance(6.0)
    assert sim.truth.velocity == pytest.approx((0.0, 0.0, 0.0), abs=0.02)
    assert sim.truth.position[1:] == pytest.approx((2.0, -30.0), abs=0.05)


def test_a_reset_of_the_estimate_does_not_move_the_vehicle() -> None:
    errors = EstimatorErrors.model_validate(
        {"position": {"wander_m": 0.5, "wander_time_s": 1e4}, "resets_per_hour": 1800.0}
    )
    motion = np.zeros(13)
    motion[2], motion[6] = -30.0, 1.0
    sim = Simulation(SITL, Conditions(name="jumpy", estimator=errors), seed=3, motion=motion)
    sim.advance(10.0)
    assert sim.firmware.estimate.resets > 1
    assert sim.truth.position == pytest.approx((0.0, 0.0, -30.0), abs=0.05)


def test_checks_before_arming_say_what_they_find_unless_they_are_off() -> None:
    sim = simulation(SITL)
    sim.firmware.set_parameter("BATT_LOW_VOLT", 100.0)
    assert sim.firmware.check() is Result.ACCEPTED
    assert "PreArm: Battery failsafe" in texts(sim)
    assert sim.firmware.arm() is Result.FAILED
    sim.firmware.set_parameter("ARMING_CHECK", 0)
    assert sim.firmware.arm() is Result.ACCEPTED
    assert sim.firmware.check() is Result.TEMPORARILY_REJECTED
