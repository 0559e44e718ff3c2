"""How fast an estimated position moves beside its own velocity."""

import numpy as np

from companion.arrays import Vec3
from companion.flight.drift import SlowDrift
from companion.state import VehicleState


def _state(time_s: float, position: Vec3, velocity: Vec3) -> VehicleState:
    return VehicleState(time_s, time_s, position, velocity, np.zeros(3), np.zeros(3))


def _drift_after(seconds: float, velocity_error: Vec3) -> Vec3:
    """Of a vehicle that accelerates, and whose velocity is wrong by as much."""
    drift = SlowDrift()
    for time_s in np.arange(0.0, seconds, 0.02).tolist():
        drift.observe(
            _state(time_s, np.full(3, 0.5 * time_s**2), np.full(3, time_s) + velocity_error),
        )
    return drift.velocity


def test_a_right_velocity_does_not_drift() -> None:
    np.testing.assert_allclose(_drift_after(5.0, np.zeros(3)), np.zeros(3), atol=1e-9)


def test_a_wrong_velocity_shows_within_seconds() -> None:
    error = np.array((0.3, -0.2, 0.1))
    np.testing.assert_allclose(_drift_after(5.0, error), -error, rtol=0.01)
    assert np.abs(_drift_after(0.1, error)).max() < 0.01


def test_noise_of_a_position_is_no_drift() -> None:
    rng, drift = np.random.default_rng(0), SlowDrift()
    largest = 0.0
    for k in range(1000):
        drift.observe(_state(0.02 * k, rng.normal(scale=0.01, size=3), np.zeros(3)))
        largest = max(largest, float(np.abs(drift.velocity).max()))
    assert largest < 0.05


def test_a_gap_and_a_jump_are_no_drift() -> None:
    drift = SlowDrift()
    drift.observe(_state(0.0, np.zeros(3), np.zeros(3)))
    drift.observe(_state(1.0, np.ones(3), np.zeros(3)))
    np.testing.assert_array_equal(drift.velocity, np.zeros(3))
    drift.forget()
    drift.observe(_state(1.02, np.full(3, 5.0), np.zeros(3)))
    np.testing.assert_array_equal(drift.velocity, np.zeros(3))
