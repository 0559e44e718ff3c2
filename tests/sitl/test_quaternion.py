import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from sitl import quaternion
from sitl.arrays import Quaternion, Vec3

angle = st.floats(-3.0, 3.0)
rotation_vectors = st.tuples(angle, angle, angle).map(lambda v: np.array(v))
vectors = st.tuples(*[st.floats(-10.0, 10.0)] * 3).map(lambda v: np.array(v))


def as_rotation(q: Quaternion) -> Rotation:
    return Rotation.from_quat(q, scalar_first=True)


@given(rotation_vectors, vectors)
def test_rotation_agrees_with_scipy_and_comes_back(turn: Vec3, v: Vec3) -> None:
    q = quaternion.from_rotation_vector(turn)
    world = quaternion.to_world(q, v)
    assert world == pytest.approx(Rotation.from_rotvec(turn).apply(v), abs=1e-9)
    assert quaternion.rotate_back(q, tuple(world)) == pytest.approx(tuple(v), abs=1e-9)


@given(rotation_vectors, rotation_vectors)
def test_product_turns_by_the_second_first(a: Vec3, b: Vec3) -> None:
    qa, qb = quaternion.from_rotation_vector(a), quaternion.from_rotation_vector(b)
    both = as_rotation(qa) * as_rotation(qb)
    difference = as_rotation(quaternion.multiply(qa, qb)).inv() * both
    assert difference.magnitude() == pytest.approx(0.0, abs=1e-9)


@given(rotation_vectors)
def test_axes_of_a_rotation_give_it_back(turn: Vec3) -> None:
    matrix = Rotation.from_rotvec(turn).as_matrix()
    q = quaternion.from_axes(*(np.ascontiguousarray(column) for column in matrix.T))
    assert as_rotation(q).as_matrix() == pytest.approx(matrix, abs=1e-9)


@given(st.floats(-math.pi + 1e-6, math.pi - 1e-6))
def test_yaw_comes_back(yaw: float) -> None:
    assert quaternion.yaw_of(quaternion.from_yaw(yaw)) == pytest.approx(yaw, abs=1e-12)
