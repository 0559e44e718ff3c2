"""An attitude seen facing north keeps its tilt whatever the yaw."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from companion.state.heading import facing_north

TILT = st.floats(-1.2, 1.2)
YAW = st.floats(-3.0, 3.0)
RATE = st.floats(-5.0, 5.0)


@given(TILT, TILT, YAW)
def test_the_thrust_axis_is_kept(roll: float, pitch: float, yaw: float) -> None:
    levelled, _ = facing_north(np.array([roll, pitch, yaw]), np.zeros(3), yaw)
    down = Rotation.from_euler("ZYX", [yaw, pitch, roll]).apply([0.0, 0.0, 1.0])
    seen = Rotation.from_euler("ZYX", [0.0, levelled[1], levelled[0]]).apply([0.0, 0.0, 1.0])
    np.testing.assert_allclose(seen, down, atol=1e-12)
    assert abs(levelled[2]) < 1e-12


@given(TILT, TILT, RATE, RATE, RATE)
def test_facing_north_changes_nothing(roll: float, pitch: float, p: float, q: float, r: float) -> None:
    attitude, rates = facing_north(np.array([roll, pitch, 0.0]), np.array([p, q, r]), 0.0)
    np.testing.assert_allclose(attitude, [roll, pitch, 0.0], atol=1e-12)
    np.testing.assert_allclose(rates, [p, q, r], atol=1e-12)


@given(YAW, RATE, RATE)
def test_rates_when_level_are_those_about_the_ned_axes(yaw: float, p: float, q: float) -> None:
    _, rates = facing_north(np.array([0.0, 0.0, yaw]), np.array([p, q, 0.0]), yaw)
    np.testing.assert_allclose(rates, Rotation.from_euler("Z", yaw).apply([p, q, 0.0]), atol=1e-12)


def test_the_yaw_error_is_the_short_way_round() -> None:
    levelled, _ = facing_north(np.array([0.0, 0.0, 3.0]), np.zeros(3), -3.0)
    assert np.isclose(levelled[2], 6.0 - 2.0 * np.pi)
