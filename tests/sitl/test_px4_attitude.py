import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from sitl_flights import BEBOP2, with_parameters

from sitl.arrays import Quaternion, Vec3
from sitl.firmware.px4_allocation import allocate, allocation
from sitl.firmware.px4_attitude import (
    RateState,
    attitude_gains,
    begin_turning,
    control_attitude,
    control_rates,
    rate_gains,
    rate_state,
    tilt_first,
)
from sitl.firmware.px4_parameters import Px4Parameters
from sitl.firmware.px4_position import AttitudeSetpoint
from sitl.firmware.px4_tuning import tuned_parameters
from sitl.quaternion import from_rotation_vector, multiply, to_world
from sitl.vehicle import load_vehicle

LEVEL = np.array((1.0, 0.0, 0.0, 0.0))
DOWN = np.array((0.0, 0.0, 1.0))
component = st.floats(-1.0, 1.0)
turns = st.tuples(component, component, component).map(lambda v: from_rotation_vector(np.array(v)))


def rates_towards(target: Quaternion, attitude: Quaternion = LEVEL, yaw_rate: float = 0.0) -> Vec3:
    state = rate_state()
    setpoint = AttitudeSetpoint(target, np.array((0.5, yaw_rate)))
    control_attitude(attitude_gains(Px4Parameters()), setpoint, attitude, state)
    return state.setpoint


@pytest.mark.parametrize(("axis", "gain"), [(0, 6.5), (1, 6.5), (2, 2.8)])
def test_small_errors_are_answered_by_the_axis_gain(axis: int, gain: float) -> None:
    error = np.zeros(3)
    error[axis] = 0.02
    expected = np.zeros(3)
    expected[axis] = 0.02 * gain
    assert rates_towards(from_rotation_vector(error)) == pytest.approx(expected, rel=1e-3)
    assert rates_towards(-from_rotation_vector(error)) == pytest.approx(expected, rel=1e-3)


@given(turns, turns)
def test_tilt_is_corrected_in_full_whatever_the_yaw(attitude: Quaternion, target: Quaternion) -> None:
    flown = multiply(attitude, tilt_first(attitude, target, 0.0))
    assert to_world(flown, DOWN) == pytest.approx(to_world(target, DOWN), abs=1e-9)
    full = multiply(attitude, tilt_first(attitude, target, 1.0))
    assert abs(full @ target) == pytest.approx(1.0, abs=1e-9)


def test_rates_are_limited() -> None:
    limit = math.radians(220.0)
    assert rates_towards(from_rotation_vector(np.array((2.5, 0.0, 0.0))))[0] == pytest.approx(limit)


def test_yaw_rate_turns_about_the_world_s_down_axis() -> None:
    tilted = from_rotation_vector(np.array((0.5, 0.0, 0.0)))
    rates = rates_towards(tilted, tilted, yaw_rate=1.0)
    assert to_world(tilted, rates) == pytest.approx((0.0, 0.0, 1.0), abs=1e-9)


def test_rate_controller_is_a_pid_with_derivative_on_the_measurement() -> None:
    gains = rate_gains(Px4Parameters(IMU_GYRO_CUTOFF=0.0))
    state = rate_state()
    state.setpoint[:] = (1.0, 0.0, 0.0)
    torque = control_rates(gains, state, np.zeros(3), False, 1e-3)
    assert torque == pytest.approx((0.15, 0.0, 0.0))
    for _ in range(999):
        torque = control_rates(gains, state, np.zeros(3), False, 1e-3)
    fade = 1.0 - (1.0 / math.radians(400.0)) ** 2
    assert torque[0] == pytest.approx(0.15 + 0.2 * fade, rel=2e-3)
    before = torque[0]
    torque = control_rates(gains, state, np.array((0.01, 0.0, 0.0)), False, 1e-3)
    assert torque[0] < before - 0.15 * 0.01


def test_gyro_is_low_passed_for_the_controller() -> None:
    gains = rate_gains(Px4Parameters())
    state = rate_state()
    turning = np.array((1.0, -2.0, 0.5))
    control_rates(gains, state, turning, False, 1e-3)
    assert np.all(np.abs(state.rates[0]) < 0.05 * np.abs(turning))
    for _ in range(100):
        control_rates(gains, state, turning, False, 1e-3)
    assert state.rates[0] == pytest.approx(turning, rel=1e-6)
    assert state.acceleration == pytest.approx((0.0, 0.0, 0.0), abs=1e-3)


def test_filters_that_begin_turning_see_no_acceleration() -> None:
    state = rate_state()
    turning = np.array((1.0, -2.0, 0.5))
    begin_turning(state, turning)
    control_rates(rate_gains(Px4Parameters()), state, turning, False, 1e-3)
    assert state.rates[0] == pytest.approx(turning)
    assert state.acceleration == pytest.approx((0.0, 0.0, 0.0), abs=1e-9)


def test_only_the_yaw_torque_is_low_passed() -> None:
    gains = rate_gains(Px4Parameters(MC_YAWRATE_I=0.0))
    state = rate_state()
    state.setpoint[:] = (1.0, 1.0, 1.0)
    torque = control_rates(gains, state, np.zeros(3), False, 1e-3)
    assert torque[:2] == pytest.approx((0.15, 0.15))
    assert torque[2] < 0.02 * 0.2
    time_constant_s = 1.0 / (2.0 * math.pi * 2.0)
    for _ in range(round(time_constant_s * 1000) - 1):
        torque = control_rates(gains, state, np.zeros(3), False, 1e-3)
    assert torque[2] == pytest.approx(0.2 * (1.0 - math.exp(-1.0)), rel=0.01)


def test_rate_integral_stops_at_its_limit_at_saturation_and_on_the_ground() -> None:
    gains = rate_gains(Px4Parameters())

    def integral_after(prepare: RateState, on_ground: bool = False) -> float:
        prepare.setpoint[:] = (3.0, 0.0, 0.0)
        for _ in range(5000):
            control_rates(gains, prepare, np.zeros(3), on_ground, 1e-3)
        return float(prepare.integral[0])

    saturated = rate_state()
    saturated.short_up[0] = True
    assert integral_after(rate_state()) == 0.3
    assert integral_after(saturated) == 0.0
    assert integral_after(rate_state(), on_ground=True) == 0.0


torques = st.tuples(*[st.floats(-0.05, 0.05)] * 3).map(lambda v: np.array(v))


@given(torques, st.floats(0.3, 0.7))
def test_allocation_gives_what_the_rotors_can(torque: Vec3, thrust: float) -> None:
    vehicle = load_vehicle("iris")  # its front and rear arms differ
    matrix = allocation(vehicle)
    state = rate_state()
    given_thrusts = allocate(matrix, torque, thrust, state)
    physical = vehicle.rotor_effectiveness @ given_thrusts
    assert physical[:3] == pytest.approx(torque * matrix.torque, abs=1e-9)
    assert np.mean(given_thrusts) == pytest.approx(thrust, abs=0.02)
    assert not state.short_up.any()
    assert not state.short_down.any()


def test_px4_scaling_of_a_symmetric_quadrotor() -> None:
    """A unit of roll moves each rotor by 1/√2, of yaw by 1, of thrust by 1."""
    vehicle = load_vehicle("x500")
    mix = allocation(vehicle).mix
    assert np.abs(mix[:, :2]) == pytest.approx(math.sqrt(0.5))
    assert np.abs(mix[:, 2:]) == pytest.approx(1.0)


wild = st.tuples(*[st.floats(-3.0, 3.0)] * 3).map(lambda v: np.array(v))


@given(wild, st.floats(0.0, 1.0))
def test_rotors_stay_within_their_range(torque: Vec3, thrust: float) -> None:
    thrusts = allocate(allocation(BEBOP2), torque, thrust, rate_state())
    assert thrusts.min() >= 0.0
    assert thrusts.max() <= 1.0


def test_roll_and_pitch_come_before_yaw() -> None:
    matrix = allocation(BEBOP2)
    state = rate_state()
    wanted = np.array((0.3, 0.3, 0.9))
    thrusts = allocate(matrix, wanted, 0.5, state)
    given_torque = matrix.effect @ thrusts
    assert given_torque[:2] == pytest.approx(wanted[:2], abs=0.08)
    assert given_torque[2] < 0.6
    assert state.short_up[2]


def test_thrust_is_lowered_to_keep_roll() -> None:
    matrix = allocation(BEBOP2)
    thrusts = allocate(matrix, np.array((0.3, 0.0, 0.0)), 1.0, rate_state())
    assert (matrix.effect @ thrusts)[0] == pytest.approx(0.3)
    assert np.mean(thrusts) < 0.9


def test_tuning_fits_the_airframe_and_leaves_what_was_given() -> None:
    tuned = tuned_parameters(BEBOP2)
    authority = allocation(BEBOP2).torque / np.array(BEBOP2.inertia_kg_m2)
    assert tuned.MC_ROLLRATE_P * authority[0] == pytest.approx(25.0)
    assert tuned_parameters(with_parameters(MC_ROLLRATE_P=0.1)).MC_ROLLRATE_P == 0.1
