import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from sitl.arrays import Vec3
from sitl.firmware.px4_hover_thrust import HoverThrust
from sitl.firmware.px4_parameters import Px4Parameters
from sitl.vehicle import GRAVITY_M_S2

DT = 0.01
STILL = np.zeros(3)


def fly(
    learner: HoverThrust, truth: float, seconds: float, velocity: Vec3 = STILL, noise: float = 0.0
) -> None:
    """A vehicle that hovers at `truth` and bobs up and down."""
    rng = np.random.default_rng(1)
    for step in range(round(seconds / DT)):
        thrust = truth * (1.0 + 0.1 * math.sin(step * DT))
        climb = GRAVITY_M_S2 * (thrust / truth - 1.0) + noise * rng.standard_normal()
        learner.update(climb_acceleration=climb, thrust=thrust, velocity=velocity, dt=DT)


@given(st.floats(0.35, 0.65))
def test_learns_the_thrust_that_carries_the_weight(truth: float) -> None:
    learner = HoverThrust(Px4Parameters())
    fly(learner, truth, 10.0)
    assert learner.estimate == pytest.approx(truth, abs=0.003)
    assert learner.valid


@pytest.mark.parametrize(("seconds", "valid"), [(1.0, False), (3.0, True)])
def test_is_valid_only_after_being_certain_for_two_seconds(seconds: float, valid: bool) -> None:
    learner = HoverThrust(Px4Parameters())
    fly(learner, 0.45, seconds)
    assert learner.valid is valid


def test_knows_nothing_after_a_reset() -> None:
    learner = HoverThrust(Px4Parameters())
    fly(learner, 0.45, 5.0)
    learner.reset()
    assert not learner.valid
    assert learner.estimate == 0.5


@pytest.mark.parametrize(("truth", "limit"), [(0.2, 0.3), (0.85, 0.7)])
def test_stays_within_reach_of_the_parameter(truth: float, limit: float) -> None:
    learner = HoverThrust(Px4Parameters())
    fly(learner, truth, 30.0)
    assert learner.estimate == pytest.approx(limit)


def test_a_blow_is_rejected() -> None:
    learner = HoverThrust(Px4Parameters())
    fly(learner, 0.45, 10.0)
    before = learner.estimate
    learner.update(climb_acceleration=-50.0, thrust=0.45, velocity=STILL, dt=DT)
    assert learner.estimate == before


def test_a_lasting_change_is_believed_in_the_end() -> None:
    learner = HoverThrust(Px4Parameters())
    learner.settle(0.35)
    fly(learner, 0.6, 60.0)
    assert learner.estimate == pytest.approx(0.6, abs=0.01)


def test_noise_slows_the_learning_and_so_does_speed() -> None:
    def change(velocity: Vec3, noise: float) -> float:
        learner = HoverThrust(Px4Parameters())
        learner.settle(0.5)
        fly(learner, 0.5, 20.0, noise=noise)
        before = learner.estimate
        fly(learner, 0.45, 1.0, velocity=velocity)
        return abs(learner.estimate - before)

    calm = change(STILL, 0.0)
    assert change(STILL, 5.0) < 0.5 * calm
    assert change(np.array((20.0, 0.0, 0.0)), 0.0) < 0.5 * calm


def test_settled_is_valid_at_once() -> None:
    learner = HoverThrust(Px4Parameters())
    learner.settle(0.42)
    assert learner.valid
    assert learner.estimate == 0.42
    learner.settle(0.1)
    assert learner.estimate == pytest.approx(0.3)
