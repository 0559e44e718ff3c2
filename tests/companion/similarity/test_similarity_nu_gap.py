"""The ν-gap: a metric, with its winding number condition."""

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from companion.experiments.linear.experiment import SOURCE, TARGET
from companion.similarity.linear_system import LinearSystem
from companion.similarity.nu_gap import TransferFunction, nu_gap

gains = st.floats(0.1, 3.0)
roots = st.lists(st.floats(-0.95, 0.95), min_size=2, max_size=2)


def transfer(gain: float, poles: list[float]) -> TransferFunction:
    return TransferFunction(np.array([gain, 0.3 * gain]), np.asarray(np.poly(poles)))


@given(gain=gains, poles=roots)
def test_equal_systems_have_no_gap(gain: float, poles: list[float]) -> None:
    assert nu_gap(transfer(gain, poles), transfer(gain, poles)) == pytest.approx(0.0, abs=1e-9)


@given(first=st.tuples(gains, roots), second=st.tuples(gains, roots), third=st.tuples(gains, roots))
def test_it_is_a_metric(
    first: tuple[float, list[float]], second: tuple[float, list[float]], third: tuple[float, list[float]]
) -> None:
    p1, p2, p3 = transfer(*first), transfer(*second), transfer(*third)
    assert nu_gap(p1, p2) == pytest.approx(nu_gap(p2, p1), abs=1e-6)
    assert nu_gap(p1, p3) <= nu_gap(p1, p2) + nu_gap(p2, p3) + 1e-6


@given(scale=st.lists(st.floats(0.1, 10.0), min_size=2, max_size=2))
def test_it_does_not_depend_on_how_the_state_is_scaled(scale: list[float]) -> None:
    T = np.diag(scale)
    scaled = LinearSystem(T @ TARGET.A @ np.linalg.inv(T), T @ TARGET.B, TARGET.C @ np.linalg.inv(T))
    source = TransferFunction.of(SOURCE)
    expected = nu_gap(source, TransferFunction.of(TARGET))
    assert nu_gap(source, TransferFunction.of(scaled)) == pytest.approx(expected, rel=1e-6)


def test_constants_have_their_chordal_distance() -> None:
    first, second = (TransferFunction(np.array([gain]), np.array([1.0])) for gain in (0.5, 2.0))
    assert nu_gap(first, second) == pytest.approx(1.5 / np.sqrt(1.25 * 5.0))


def test_a_dense_grid_finds_the_same() -> None:
    first, second = TransferFunction.of(SOURCE), TransferFunction.of(TARGET)
    z = np.exp(1j * np.linspace(0.0, np.pi, 200_001))
    p1, p2 = (np.polyval(each.numerator, z) / np.polyval(each.denominator, z) for each in (first, second))
    expected = np.max(np.abs(p1 - p2) / np.sqrt((1.0 + np.abs(p1) ** 2) * (1.0 + np.abs(p2) ** 2)))
    assert nu_gap(first, second) == pytest.approx(float(expected), rel=1e-6)


@given(first=st.floats(0.05, 0.95), second=st.floats(0.05, 0.95), gain=st.floats(5.0, 50.0))
def test_poles_on_both_sides_of_the_circle_are_near_if_one_controller_serves_both(
    first: float, second: float, gain: float
) -> None:
    stable = TransferFunction(np.array([gain]), np.array([1.0, -first]))
    unstable = TransferFunction(np.array([gain]), np.array([1.0, -(2.0 - second)]))
    assert nu_gap(stable, unstable) < 0.5


def test_a_winding_number_makes_near_values_far_systems() -> None:
    weak_stable = TransferFunction(np.array([0.01]), np.array([1.0, -0.5]))
    weak_unstable = TransferFunction(np.array([0.01]), np.array([1.0, -2.0]))
    assert nu_gap(weak_stable, weak_unstable) == 1.0


@given(poles=roots, delay=st.integers(1, 5))
def test_dead_time_counts(poles: list[float], delay: int) -> None:
    assume(max(np.abs(poles)) < 0.9)
    system = LinearSystem(np.diag(poles), np.ones(2), np.array([0.5, 0.7]))
    assert nu_gap(TransferFunction.of(system), TransferFunction.of(system, delay)) > 0.05


@given(delay=st.floats(0.05, 3.0))
def test_a_part_of_a_step_delays_slow_signals_by_just_that(delay: float) -> None:
    system = LinearSystem(np.array([[0.5]]), np.array([0.5]), np.array([1.0]))
    z = np.exp(1j * 0.05)
    plain, delayed = (
        np.polyval(each.numerator, z) / np.polyval(each.denominator, z)
        for each in (TransferFunction.of(system), TransferFunction.of(system, delay))
    )
    assert np.angle(delayed / plain) == pytest.approx(-0.05 * delay, abs=2e-4 + 0.05 * 0.02)
