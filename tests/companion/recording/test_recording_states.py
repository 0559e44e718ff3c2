"""Positions, attitudes and rates of different times, joined."""

import numpy as np
import pytest

from companion.arrays import Array, Times
from companion.errors import InputError
from companion.recording.states import body_rates, joined_states, roll_pitch_yaw


def motion(time_s: Times) -> Array:
    return np.outer(time_s, np.ones(6))


def test_attitude_and_rates_are_taken_between_their_neighbours() -> None:
    time_s = np.array([1.02, 1.05])
    attitude_s = np.array([1.0, 1.04, 1.08])
    angles = np.outer([0.0, 0.4, 0.8], [1.0, -1.0, 0.5])
    states = joined_states((time_s, motion(time_s)), (attitude_s, angles), (attitude_s, 2.0 * angles))
    np.testing.assert_allclose(states.attitude, np.outer([0.2, 0.5], [1.0, -1.0, 0.5]))
    np.testing.assert_allclose(states.rates, np.outer([0.4, 1.0], [1.0, -1.0, 0.5]))
    assert states.position.tolist() == motion(time_s)[:, :3].tolist()


def test_the_yaw_is_taken_across_its_jump_at_pi() -> None:
    yaw = np.array([[0.0, 0.0, 3.1], [0.0, 0.0, -3.1]])
    time_s = np.array([0.0, 0.1])
    middle = np.array([0.05])
    states = joined_states((middle, motion(middle)), (time_s, yaw), (time_s, yaw))
    assert abs(abs(states.attitude[0, 2]) - np.pi) < 1e-9


def test_repeated_and_backward_and_broken_rows_are_left_out() -> None:
    time_s = np.array([0.0, 0.1, 0.1, 0.05, 0.2, 0.3])
    moved = motion(time_s)
    moved[4, 5] = np.nan
    angles = np.zeros((6, 3))
    states = joined_states((time_s, moved), (time_s, angles), (time_s, angles))
    assert states.time_s.tolist() == [0.0, 0.1, 0.3]


def test_a_position_without_an_attitude_near_is_no_state() -> None:
    time_s = np.array([0.0, 0.5, 1.0])
    attitude_s = np.array([0.05, 1.05])
    angles = np.zeros((2, 3))
    states = joined_states((time_s, motion(time_s)), (attitude_s, angles), (attitude_s, angles))
    assert states.time_s.tolist() == [0.0, 1.0]
    with pytest.raises(InputError, match="no local position with an attitude"):
        joined_states((time_s + 9.0, motion(time_s)), (attitude_s, angles), (attitude_s, angles))
    with pytest.raises(InputError, match="no local position with an attitude"):
        joined_states((time_s, motion(time_s)), (attitude_s[:0], angles[:0]), (attitude_s, angles))


def test_a_quaternion_becomes_roll_pitch_and_yaw() -> None:
    half = np.array([0.1, -0.2, 1.5]) / 2.0
    (cr, cp, cy), (sr, sp, sy) = np.cos(half), np.sin(half)
    quaternion = np.array(  # Hamilton product of yaw, pitch and roll about their own axes
        [
            cr * cp * cy + sr * sp * sy,
            sr * cp * cy - cr * sp * sy,
            cr * sp * cy + sr * cp * sy,
            cr * cp * sy - sr * sp * cy,
        ]
    )
    angles = roll_pitch_yaw(np.array([quaternion, np.zeros(4), quaternion * np.nan]))
    np.testing.assert_allclose(angles[0], [0.1, -0.2, 1.5])
    assert np.isnan(angles[1:]).all()


def test_rates_are_found_in_the_body_s_own_axes() -> None:
    time_s = np.linspace(0.0, 1.0, 11)
    spin = np.column_stack((np.cos(time_s), np.sin(time_s), 0.0 * time_s, 0.0 * time_s))  # 2 rad/s about x
    yawed = np.sqrt(0.5) * np.column_stack((spin[:, 0], spin[:, 1], spin[:, 1], spin[:, 0]))
    rates = body_rates(time_s, yawed)
    np.testing.assert_allclose(rates[:-1], np.tile([2.0, 0.0, 0.0], (10, 1)), atol=1e-9)
    assert np.isnan(rates[-1]).all()
