import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from sitl.arrays import Quaternion
from sitl.firmware.ardupilot_attitude import (
    attitude_error,
    attitude_gains,
    attitude_state,
    begin_attitude,
    control_attitude,
    lean_towards,
    shape_attitude,
)
from sitl.firmware.ardupilot_motors import authority, mix, mixer
from sitl.firmware.ardupilot_parameters import ArduPilotParameters
from sitl.quaternion import from_rotation_vector, from_yaw, multiply, rotate, yaw_of
from sitl.vehicle import GRAVITY_M_S2, load_vehicle

DT = 0.0025
GAINS = attitude_gains(ArduPilotParameters())
SITL = load_vehicle("arducopter_sitl")
accelerations = st.floats(-5.0, 5.0)
angles = st.floats(-3.0, 3.0)


def turned(*vector: float) -> Quaternion:
    return from_rotation_vector(np.array(vector))


# Attitude


@given(accelerations, accelerations, angles)
def test_lean_gives_the_acceleration_while_it_holds_the_weight(x: float, y: float, heading: float) -> None:
    attitude = lean_towards(np.array((x, y, 3.0)), heading)
    up = rotate(attitude, (0.0, 0.0, -1.0))
    scale = GRAVITY_M_S2 / -up[2]
    assert (scale * up[0], scale * up[1]) == pytest.approx((x, y), abs=1e-9)
    assert float(np.linalg.norm(attitude)) == pytest.approx(1.0)
    if x == y == 0.0:
        assert yaw_of(attitude) == pytest.approx(heading)


@given(angles, angles, angles, st.floats(-0.7, 0.7), st.floats(-0.7, 0.7), angles)
def test_error_turns_the_thrust_first_and_then_the_heading(
    a: float, b: float, c: float, roll: float, pitch: float, heading: float
) -> None:
    attitude = turned(0.3 * a, 0.3 * b, c)
    wanted = multiply(attitude, multiply(turned(roll, pitch, 0.0), from_yaw(heading)))
    assert attitude_error(attitude, wanted) == pytest.approx((roll, pitch, heading), abs=1e-9)


def test_target_follows_within_angular_acceleration_and_the_yaw_rate_limit() -> None:
    state = attitude_state()
    wanted = multiply(turned(0.3, -0.2, 0.0), from_yaw(1.5))
    fastest, last = np.zeros(3), np.array((0.0, 0.0, 0.0))
    for _ in range(2000):
        shape_attitude(GAINS, state, wanted, 0.0, False, DT)
        rates = state.target_rates.copy()
        assert (np.abs(rates - last) / DT <= GAINS.acceleration * (1.0 + 1e-9)).all()
        last[:] = rates
        fastest[:] = np.maximum(fastest, np.abs(rates))
    assert attitude_error(state.target, wanted) == pytest.approx((0.0, 0.0, 0.0), abs=1e-3)
    assert fastest[2] == pytest.approx(math.radians(60.0))  # ATC_SLEW_YAW


def test_turning_at_a_rate_does_not_look_at_the_heading() -> None:
    state = attitude_state()
    for _ in range(400):
        shape_attitude(GAINS, state, from_yaw(0.0), 0.5, True, DT)
    assert state.target_rates[2] == pytest.approx(0.5)
    assert yaw_of(state.target) == pytest.approx(0.5, abs=0.1)


def test_rates_are_those_of_the_target_plus_a_correction() -> None:
    state = attitude_state()
    begin_attitude(state, turned(0.1, 0.0, 0.0), np.array((0.0, 0.7, 0.0)))
    control_attitude(GAINS, state, turned(0.1, 0.0, 0.0), np.zeros(3), DT)
    assert state.rates == pytest.approx((0.0, 0.7, 0.0))
    control_attitude(GAINS, state, turned(0.08, 0.0, 0.0), np.zeros(3), DT)
    assert state.rates[0] == pytest.approx(4.5 * 0.02, rel=0.01)  # ATC_ANG_RLL_P


def test_far_off_the_thrust_comes_first() -> None:
    state = attitude_state()
    begin_attitude(state, multiply(turned(1.2, 0.0, 0.0), from_yaw(0.2)), np.array((0.0, 0.0, 0.5)))
    control_attitude(GAINS, state, turned(0.0, 0.0, 0.0), np.array((0.0, 0.0, -0.3)), DT)
    assert state.rates[0] > 1.0
    assert state.rates[2] == pytest.approx(-0.3)  # as it turns anyway


def test_a_heading_out_of_reach_is_not_wound_up() -> None:
    state = attitude_state()
    begin_attitude(state, from_yaw(2.5), np.zeros(3))
    control_attitude(GAINS, state, from_yaw(0.0), np.zeros(3), DT)
    assert yaw_of(state.target) == pytest.approx(GAINS.heading_error)


# Motors


def test_mix_gives_roll_pitch_yaw_and_throttle() -> None:
    limits = np.zeros(4, dtype=np.bool_)
    frame = mixer(SITL, 0.2)
    effect = SITL.rotor_effectiveness
    for axis in range(3):
        output = np.zeros(3)
        output[axis] = 0.1
        thrusts = mix(frame, output, 0.4, 0.45, limits)
        torque = effect @ thrusts
        assert torque[3] == pytest.approx(0.4 * effect[3].sum())
        assert torque[axis] / SITL.inertia_kg_m2[axis] == pytest.approx(0.1 * authority(SITL)[axis])
        assert np.delete(torque[:3], axis) == pytest.approx((0.0, 0.0), abs=1e-9)
    assert not limits.any()


@given(
    st.floats(-3.0, 3.0),
    st.floats(-3.0, 3.0),
    st.floats(-3.0, 3.0),
    st.floats(-0.5, 1.5),
    st.floats(0.0, 1.0),
)
def test_mix_stays_within_the_rotors(
    roll: float, pitch: float, yaw: float, throttle: float, mean: float
) -> None:
    limits = np.zeros(4, dtype=np.bool_)
    thrusts = mix(mixer(SITL, 0.2), np.array((roll, pitch, yaw)), throttle, mean, limits)
    assert ((thrusts >= 0.0) & (thrusts <= 1.0)).all()


def test_mix_tells_what_fell_short() -> None:
    limits = np.zeros(4, dtype=np.bool_)
    frame = mixer(SITL, 0.2)
    mix(frame, np.array((0.0, 0.0, 1.5)), 0.4, 0.45, limits)
    assert limits.tolist() == [False, True, False, False]
    mix(frame, np.array((2.0, 0.0, 0.0)), 0.4, 0.45, limits)
    assert limits[0]
    mix(frame, np.zeros(3), 0.0, 0.2, limits)
    assert limits.tolist() == [False, False, True, False]
    mix(frame, np.zeros(3), 1.2, 1.0, limits)
    assert limits.tolist() == [False, False, False, True]


def test_throttle_rises_for_roll_but_no_further_than_allowed() -> None:
    limits = np.zeros(4, dtype=np.bool_)
    frame = mixer(SITL, 0.2)
    roll = np.array((0.5, 0.0, 0.0))
    assert mix(frame, roll, 0.1, 0.3, limits).mean() == pytest.approx(0.25)
    assert not limits[0]
    scaled = mix(frame, roll, 0.1, 0.1, limits)
    assert scaled.mean() == pytest.approx(0.1)
    assert limits[0]
