"""Where the vehicle was, between its states."""

import numpy as np

from companion.arrays import Vec3
from companion.flight.motion_history import MotionHistory
from companion.state import VehicleState


def _state(time_s: float, position: Vec3, velocity: Vec3) -> VehicleState:
    return VehicleState(time_s, time_s, position, velocity, np.zeros(3), np.zeros(3))


def test_a_motion_is_interpolated_but_not_across_gaps() -> None:
    history = MotionHistory(span_s=10.0)
    for time_s in (0.0, 0.1, 0.5):
        history.append(_state(time_s, np.array([time_s, 2.0 * time_s, 0.0]), np.full(3, time_s)))
    np.testing.assert_allclose(history.position(0.04, (0.0, 0.01, 0.0)), [0.04, 0.10, 0.0])
    np.testing.assert_allclose(history.velocity(0.1, (0.0, 0.0, 0.0)), np.full(3, 0.1))
    for unknown_s in (-0.1, 0.3, 0.6):
        assert np.isnan(history.position(unknown_s, (0.0, 0.0, 0.0))).all()


def test_recent_acceleration_and_drift() -> None:
    history = MotionHistory(span_s=10.0)
    states = [
        _state(t, np.array([0.0, 0.5 * t**2 + 0.3 * t, t]), np.array([0.0, t, 1.0])) for t in (1.0, 1.1)
    ]
    for state in states:
        history.append(state)
    acceleration, drift = history.recent(states[1])
    np.testing.assert_allclose(acceleration, [0.0, 1.0, 0.0], atol=1e-9)
    np.testing.assert_allclose(drift, [0.0, 0.3, 0.0], atol=1e-9)
    np.testing.assert_array_equal(history.recent(states[0]), np.zeros((2, 3)))


def test_a_long_history_forgets_what_is_too_old() -> None:
    history = MotionHistory(span_s=1.0)
    for k in range(1000):
        history.append(_state(0.01 * k, np.zeros(3), np.zeros(3)))
    assert np.isnan(history.position(5.0, (0.0, 0.0, 0.0))).all()
    assert np.isfinite(history.position(9.5, (0.0, 0.0, 0.0))).all()
