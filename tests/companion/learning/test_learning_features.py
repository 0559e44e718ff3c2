import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from pydantic import ValidationError

from companion.arrays import Vec3
from companion.learning.features import (
    ACCELERATING_OUTPUTS,
    ERROR_INPUTS,
    INVERSE_INPUTS,
    INVERSE_OUTPUTS,
    STATE,
    Preview,
    error_inputs,
    inverse_inputs,
    inverse_outputs,
    reference,
    state_vector,
    tilt,
)

RNG = np.random.default_rng(0)
POSITION, VELOCITY, ATTITUDE, RATES = RNG.normal(scale=0.3, size=(4, 7, 3))
DESIRED, DESIRED_VELOCITY, REFERENCE, REFERENCE_VELOCITY, ACCELERATION = RNG.normal(size=(5, 7, 3))

angles = st.floats(-1.0, 1.0)
headings = st.floats(-np.pi, np.pi)
vectors = arrays(float, 3, elements=st.floats(-10.0, 10.0))


def test_there_is_a_name_for_every_number() -> None:
    x = state_vector(POSITION, VELOCITY, ATTITUDE, RATES)
    assert x.shape == (7, len(STATE)) == (7, 12)
    assert inverse_inputs(x, DESIRED, DESIRED_VELOCITY).shape == (7, len(INVERSE_INPUTS)) == (7, 12)
    assert inverse_outputs(x, REFERENCE, REFERENCE_VELOCITY).shape == (7, len(INVERSE_OUTPUTS)) == (7, 6)
    assert inverse_outputs(x, REFERENCE, REFERENCE_VELOCITY, ACCELERATION).shape == (7, 9)
    assert len(set(ACCELERATING_OUTPUTS)) == 9
    i2 = error_inputs(x, REFERENCE, REFERENCE_VELOCITY, DESIRED, DESIRED_VELOCITY)
    assert i2.shape == (7, len(ERROR_INPUTS)) == (7, 24)
    assert len(set(ERROR_INPUTS)) == 24


def test_one_sample_is_a_row_of_many() -> None:
    many = inverse_inputs(state_vector(POSITION, VELOCITY, ATTITUDE, RATES), DESIRED, DESIRED_VELOCITY)
    for row in range(7):
        x = state_vector(POSITION[row], VELOCITY[row], ATTITUDE[row], RATES[row])
        np.testing.assert_array_equal(inverse_inputs(x, DESIRED[row], DESIRED_VELOCITY[row]), many[row])


def test_facing_north_the_vector_is_the_papers() -> None:
    attitude = ATTITUDE * (1.0, 1.0, 0.0)
    i1 = inverse_inputs(state_vector(POSITION, VELOCITY, attitude, RATES), DESIRED, DESIRED_VELOCITY)
    expected = np.hstack((DESIRED - POSITION, DESIRED_VELOCITY - VELOCITY, attitude, RATES))
    np.testing.assert_allclose(i1, expected, atol=1e-15)


@given(sent=st.tuples(vectors, vectors, st.none() | vectors), position=vectors, velocity=vectors)
def test_reference_undoes_inverse_outputs(
    sent: tuple[Vec3, Vec3, Vec3 | None], position: Vec3, velocity: Vec3
) -> None:
    x = state_vector(position, velocity, ATTITUDE[0], RATES[0])
    again = reference(x, inverse_outputs(x, *sent))
    for before, after in zip(sent, again, strict=True):
        assert (before is None) == (after is None)
        if before is not None and after is not None:
            np.testing.assert_allclose(after, before, atol=1e-12)


@given(roll=angles, pitch=angles, length=st.floats(0.1, 20.0))
def test_the_tilt_is_that_of_the_down_axis(roll: float, pitch: float, length: float) -> None:
    np.testing.assert_allclose(tilt(length * rotation(roll, pitch, 0.0)[:, 2]), (roll, pitch), atol=1e-12)


def rotation(roll: float, pitch: float, yaw: float) -> np.ndarray:
    c, s = np.cos, np.sin
    about_x = np.array([[1, 0, 0], [0, c(roll), -s(roll)], [0, s(roll), c(roll)]])
    about_y = np.array([[c(pitch), 0, s(pitch)], [0, 1, 0], [-s(pitch), 0, c(pitch)]])
    about_z = np.array([[c(yaw), -s(yaw), 0], [s(yaw), c(yaw), 0], [0, 0, 1]])
    return np.asarray(about_z @ about_y @ about_x)


@given(roll=angles, pitch=angles, yaw=headings)
def test_thrust_points_the_same_way_at_every_heading(roll: float, pitch: float, yaw: float) -> None:
    x = state_vector(np.zeros(3), np.zeros(3), np.array([roll, pitch, yaw]), np.zeros(3))
    seen_roll, seen_pitch, seen_yaw = x[6:9]
    assert seen_yaw == 0.0
    np.testing.assert_allclose(
        rotation(seen_roll, seen_pitch, 0.0)[:, 2], rotation(roll, pitch, yaw)[:, 2], atol=1e-12
    )


def test_previews() -> None:
    paper = Preview.of_steps((4, 4, 3), 1 / 7)
    np.testing.assert_allclose(paper.position_s, (4 / 7, 4 / 7, 3 / 7))
    np.testing.assert_allclose(paper.velocity_s, (3 / 7, 3 / 7, 2 / 7))
    assert paper.longest_s == pytest.approx(4 / 7)
    assert Preview.of_time(0.36).velocity_s == (0.36, 0.36, 0.36)
    with pytest.raises(ValidationError):
        Preview.of_time(float("nan"))
