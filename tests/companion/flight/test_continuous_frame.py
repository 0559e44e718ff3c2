from collections.abc import Iterator

import numpy as np
import pytest

from companion.arrays import Vec3
from companion.flight.continuous_frame import ContinuousFrame
from companion.flight.reference import Reference
from companion.state import VehicleState

JUMP = np.array([1.0, -0.5, 0.3])
JUMPS_AT_S = 2.0
VELOCITY = np.array([1.0, 0.5, 0.0])


def state(time_s: float, position: Vec3, velocity: Vec3 = VELOCITY) -> VehicleState:
    return VehicleState(time_s, time_s, position, velocity, np.zeros(3), np.zeros(3))


def states(jump: Vec3 = JUMP, rate_hz: float = 50.0) -> Iterator[VehicleState]:
    """Flight at constant velocity for 15 s, with an estimate that jumps."""
    for step in range(round(15.0 * rate_hz)):
        time_s = step / rate_hz
        yield state(time_s, time_s * VELOCITY + (jump if time_s >= JUMPS_AT_S else 0.0))


def test_without_jumps_it_is_the_vehicles_own_frame() -> None:
    frame = ContinuousFrame()
    for each in states(np.zeros(3)):
        assert frame.follow(each) is None
        assert frame.tracked(each).position.tobytes() == each.position.tobytes()
        assert frame.tracked(each).velocity.tobytes() == each.velocity.tobytes()


@pytest.mark.parametrize("rate_hz", [4.0, 30.0, 100.0])
def test_what_is_tracked_does_not_jump_and_moves_as_its_velocity_says(rate_hz: float) -> None:
    frame = ContinuousFrame()
    jumps, tracked = [], []
    for each in states(rate_hz=rate_hz):
        jumps.append(frame.follow(each))
        tracked.append(frame.tracked(each))
    (jump,) = [jump for jump in jumps if jump is not None]
    np.testing.assert_allclose(jump, JUMP, atol=1e-9)
    positions = np.array([each.position for each in tracked])
    velocities = np.array([each.velocity for each in tracked])
    beside = np.diff(positions, axis=0) - 0.5 * (velocities[1:] + velocities[:-1]) / rate_hz
    assert np.abs(beside).max() < 2e-4
    assert np.abs(np.diff(velocities, axis=0)).max() < 0.1 / rate_hz


def test_a_setpoint_moves_with_the_jump_and_returns_slowly() -> None:
    frame, sent = ContinuousFrame(), []
    aim = Reference(np.zeros(3), np.zeros(3))
    for each in states():
        frame.follow(each)
        sent.append(frame.sent(aim, each.time_s).position)
    steps = np.diff(np.array(sent), axis=0)
    at_jump = round(JUMPS_AT_S * 50.0) - 1
    np.testing.assert_allclose(steps[at_jump], JUMP, atol=1e-9)
    others = np.delete(steps, at_jump, axis=0)
    assert np.linalg.norm(others, axis=1).max() < 0.15 / 50.0
    assert np.linalg.norm(sent[-1]) < 0.25 * np.linalg.norm(JUMP)


def test_noise_and_wander_of_an_estimate_are_no_jump() -> None:
    frame, rng = ContinuousFrame(), np.random.default_rng(1)
    for each in states(np.zeros(3)):
        noisy = state(each.time_s, each.position + 0.03 * rng.standard_normal(3))
        assert frame.follow(noisy) is None


def test_after_a_long_silence_nothing_counts_as_a_jump() -> None:
    frame = ContinuousFrame()
    frame.follow(state(0.0, np.zeros(3)))
    assert frame.follow(state(5.0, np.array([20.0, 0.0, 0.0]))) is None
