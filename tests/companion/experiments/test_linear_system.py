"""Gains, relative degree, poles and zeros of linear systems."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.testing import assert_allclose

from companion.errors import InputError
from companion.experiments.linear.experiment import AMPLIFYING_TARGET, SOURCE, TARGET
from companion.experiments.linear.system import LinearSystem

SECOND_DEGREE = LinearSystem(
    A=np.array([[0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [0.05, -0.4, 1.0]]),
    B=np.array([0.0, 0.0, 1.0]),
    C=np.array([-0.3, 1.0, 0.0]),
)


@pytest.mark.parametrize(
    ("system", "poles", "zeros"), [(SOURCE, [0.3, 0.5], [0.2]), (TARGET, [0.4, 0.6], [0.1])]
)
def test_paper_systems_have_the_poles_and_zeros_that_the_paper_states(
    system: LinearSystem, poles: list[float], zeros: list[float]
) -> None:
    assert system.relative_degree == 1
    assert_allclose(np.sort(system.poles.real), poles, atol=1e-12)
    assert_allclose(system.zeros, zeros, atol=1e-12)


def test_second_pair_differs_in_input_gain_and_is_minimum_phase() -> None:
    assert AMPLIFYING_TARGET.relative_degree == SOURCE.relative_degree
    assert AMPLIFYING_TARGET.input_gain != SOURCE.input_gain
    assert_allclose(AMPLIFYING_TARGET.zeros, TARGET.zeros)


def test_second_relative_degree() -> None:
    assert SECOND_DEGREE.relative_degree == 2
    assert_allclose(SECOND_DEGREE.zeros, [0.3], atol=1e-12)


def test_input_that_never_reaches_the_output_is_refused() -> None:
    deaf = LinearSystem(A=np.eye(2) * 0.5, B=np.array([0.0, 1.0]), C=np.array([1.0, 0.0]))
    with pytest.raises(InputError, match="never reaches"):
        _ = deaf.relative_degree


@given(
    state=st.lists(st.floats(-5.0, 5.0), min_size=3, max_size=3),
    reference=st.floats(-5.0, 5.0),
)
def test_gains_give_the_output_r_steps_later(state: list[float], reference: float) -> None:
    x = np.array(state)
    after = SECOND_DEGREE.step(SECOND_DEGREE.step(x, reference), 0.0)
    expected = SECOND_DEGREE.state_gain @ x + SECOND_DEGREE.input_gain * reference
    assert SECOND_DEGREE.C @ after == pytest.approx(expected, abs=1e-12)
