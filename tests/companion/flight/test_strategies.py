"""How the strategies make u1."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from companion.arrays import Vec3
from companion.experiments.contenders import find_model
from companion.flight.approach import rest_to_rest
from companion.flight.reference import Reference
from companion.flight.strategies import (
    Early,
    InverseDynamics,
    InverseFeedforward,
    position_velocity_acceleration,
)
from companion.learning.features import ACCELERATING_OUTPUTS, INVERSE_INPUTS, INVERSE_OUTPUTS, Preview
from companion.learning.inverse_network import InverseNetwork, Layer, ModelCard, Scaling
from companion.learning.online_settings import DEFAULT, ReferenceLead
from companion.state import VehicleState
from companion.trajectory import training_sinusoids
from companion.trajectory.training import LIMITS
from companion.trajectory.trajectory import Trajectory

WAVE = training_sinusoids(20.0, (1.0, 1.0, 1.0), LIMITS, 0)
LINE = rest_to_rest(np.zeros(3), np.array((2.0, 0.0, -1.0)), "line")
STATE = VehicleState(0.0, 0.0, *np.zeros((4, 3)))
OFFSET, EXTRA = np.array((0.4, -0.2, 0.1)), np.array((1.0, 0.5, -0.5))


def beside(trajectory: Trajectory, time_s: float, state: VehicleState) -> Reference:
    desired = trajectory.at(time_s)
    return Reference(desired.position + OFFSET, desired.velocity + EXTRA)


@pytest.mark.parametrize("share", [0.25, 0.5, 1.0])
def test_only_a_share_of_the_way_to_another_reference(share: float) -> None:
    desired, plain = LINE.at(0.7), position_velocity_acceleration(LINE, 0.7, STATE)
    tempered = plain.towards(beside(LINE, 0.7, STATE), share)
    np.testing.assert_allclose(tempered.position, desired.position + share * OFFSET)
    np.testing.assert_allclose(tempered.velocity, desired.velocity + share * EXTRA)
    assert tempered.acceleration is not None
    np.testing.assert_allclose(tempered.acceleration, (1.0 - share) * desired.acceleration)


def test_another_reference_pulls_as_the_autopilot_answers() -> None:
    desired, plain = LINE.at(0.7), position_velocity_acceleration(LINE, 0.7, STATE)
    pull = plain.pull_towards(beside(LINE, 0.7, STATE), np.full(3, 2.0), np.full(3, 3.0))
    np.testing.assert_allclose(pull, 2.0 * OFFSET + 3.0 * EXTRA - desired.acceleration)


def linear_network(outputs: tuple[str, ...]) -> InverseNetwork:
    """Each output is the input of its place: position and velocity ahead, and of the attitude the tilt."""
    card = ModelCard(
        inputs=INVERSE_INPUTS,
        outputs=outputs,
        preview=Preview.of_time(0.2),
        sample_time_s=0.02,
        vehicle="linear",
        data_sha256="0" * 64,
        data_seconds=400.0,
        seed=0,
        held_out_rms=(0.01,) * len(outputs),
        lookahead_s=0.2,
        software="0.1.0",
    )
    layer = Layer(np.eye(12, len(outputs), dtype=np.float32), np.zeros(len(outputs), np.float32))
    unscaled = (Scaling(np.zeros(n, np.float32), np.ones(n, np.float32)) for n in (12, len(outputs)))
    return InverseNetwork(card, (layer,), *unscaled)


PLAIN_NETWORK, ACCELERATING_NETWORK = map(linear_network, (INVERSE_OUTPUTS, ACCELERATING_OUTPUTS))
vectors = arrays(float, 3, elements=st.floats(-1.0, 1.0))


@given(vectors, vectors, vectors, vectors)
def test_the_inverse_as_feedforward_does_not_hear_the_estimate(
    position: Vec3, velocity: Vec3, attitude: Vec3, rates: Vec3
) -> None:
    law = InverseFeedforward(ACCELERATING_NETWORK)
    elsewhere = law(LINE, 0.7, VehicleState(0.0, 0.0, position, velocity, attitude, rates))
    there = law(LINE, 0.7, STATE)
    assert there.acceleration is not None
    assert elsewhere.acceleration is not None
    np.testing.assert_array_equal(elsewhere.position, there.position)
    np.testing.assert_array_equal(elsewhere.velocity, there.velocity)
    np.testing.assert_array_equal(elsewhere.acceleration, there.acceleration)


def test_an_inverse_says_position_and_velocity_and_the_trajectory_its_acceleration() -> None:
    learned, plain = (
        law(LINE, 0.7, STATE) for law in (InverseFeedforward(ACCELERATING_NETWORK), Early(DEFAULT.lead))
    )
    np.testing.assert_allclose(learned.position, LINE.at(0.9).position, atol=1e-6)
    np.testing.assert_allclose(learned.velocity, LINE.at(0.9).velocity, atol=1e-6)
    assert learned.acceleration is not None
    assert plain.acceleration is not None
    np.testing.assert_array_equal(learned.acceleration, plain.acceleration)


def test_each_part_has_its_lead_and_upwards_another() -> None:
    lead = ReferenceLead(
        position_s=0.1,
        velocity_s=0.2,
        acceleration_s=0.3,
        vertical_position_s=0.4,
        vertical_velocity_s=0.5,
        vertical_acceleration_s=0.6,
    )
    early = Early(lead)(WAVE, 5.0, STATE)
    assert early.acceleration is not None
    np.testing.assert_array_equal(early.position[:2], WAVE.at(5.1).position[:2])
    np.testing.assert_array_equal(early.velocity[:2], WAVE.at(5.2).velocity[:2])
    np.testing.assert_array_equal(early.acceleration[:2], WAVE.at(5.3).acceleration[:2])
    assert early.position[2] == WAVE.at(5.4).position[2]
    assert early.velocity[2] == WAVE.at(5.5).velocity[2]
    assert early.acceleration[2] == WAVE.at(5.6).acceleration[2]


@pytest.mark.parametrize("mirror", [(-1.0, 1.0, 1.0), (1.0, -1.0, 1.0), (-1.0, -1.0, 1.0)])
@pytest.mark.parametrize("name", ["ardrone2", "arducopter_sitl"])
def test_a_network_as_feedforward_is_alike_in_every_mirror(name: str, mirror: tuple[float, ...]) -> None:
    law = InverseFeedforward(find_model(name, DEFAULT).network)
    mirrored_wave = Trajectory("mirrored", WAVE.step_s, WAVE.coefficients * np.array(mirror))
    for time_s in (3.0, 5.0, 9.0):
        plain, mirrored = law(WAVE, time_s, STATE), law(mirrored_wave, time_s, STATE)
        np.testing.assert_allclose(mirrored.position, mirror * plain.position, atol=1e-5)
        np.testing.assert_allclose(mirrored.velocity, mirror * plain.velocity, atol=1e-5)
        assert np.abs(plain.velocity - WAVE.at(time_s).velocity).max() > 1e-3


def test_a_network_as_feedforward_leaves_an_axis_alone_that_rests() -> None:
    law = InverseFeedforward(find_model("ardrone2", DEFAULT).network)
    in_a_plane = Trajectory("plane", WAVE.step_s, WAVE.coefficients * np.array((1.0, 0.0, 1.0)))
    learned = law(in_a_plane, 5.0, STATE)
    assert abs(learned.position[1]) < 1e-6
    assert abs(learned.velocity[1]) < 1e-6


def test_of_an_inverse_without_one_all_is_fed_forward() -> None:
    learned = InverseFeedforward(PLAIN_NETWORK)(LINE, 0.7, STATE)
    np.testing.assert_allclose(learned.position, LINE.at(0.9).position, atol=1e-6)
    np.testing.assert_allclose(learned.velocity, LINE.at(0.9).velocity, atol=1e-6)


def test_the_papers_inverse_hears_it() -> None:
    tilted = replace(STATE, attitude=np.array((0.2, -0.1, 0.0)))
    acceleration = InverseDynamics(ACCELERATING_NETWORK)(LINE, 0.7, tilted).acceleration
    assert acceleration is not None
    np.testing.assert_allclose(acceleration, (0.2, -0.1, 0.0), atol=1e-6)


def test_an_acceleration_that_the_network_does_not_give_counts_as_none() -> None:
    desired = LINE.at(0.7)
    law = InverseFeedforward(PLAIN_NETWORK)
    assert law(LINE, 0.7, STATE).acceleration is None
    tempered = position_velocity_acceleration(LINE, 0.7, STATE).towards(law(LINE, 0.7, STATE), 0.3)
    assert tempered.acceleration is not None
    np.testing.assert_allclose(tempered.acceleration, 0.7 * desired.acceleration)
