"""The cautious correction against what any other correction leaves."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from companion.learning.cautious_correction import ErrorBelief

FINITE = st.floats(-10.0, 10.0)
DEVIATION = st.floats(0.01, 10.0)
BELIEFS = st.builds(
    lambda error, gain, error_deviation, gain_deviation, correlation: ErrorBelief(
        error, gain, error_deviation**2, gain_deviation**2, correlation * error_deviation * gain_deviation
    ),
    FINITE,
    FINITE,
    DEVIATION,
    DEVIATION,
    st.floats(-1.0, 1.0),
)


@given(BELIEFS, FINITE)
def test_no_other_correction_is_expected_to_leave_less(belief: ErrorBelief, other: float) -> None:
    least = belief.expected_square(belief.correction)
    assert least <= belief.expected_square(other) * (1.0 + 1e-9) + 1e-12


@given(BELIEFS)
def test_loop_is_never_overcorrected(belief: ErrorBelief) -> None:
    assert 0.0 <= belief.alpha * belief.gain <= 1.0


def test_certain_gain_is_inverted() -> None:
    belief = ErrorBelief(error=0.6, gain=-2.0)
    assert belief.alpha == -0.5
    assert belief.correction == pytest.approx(-0.3)
    assert belief.expected_square(belief.correction) == pytest.approx(0.0)


def test_expected_square_is_the_mean_of_draws() -> None:
    belief = ErrorBelief(1.0, 0.5, error_variance=0.4, gain_variance=0.3, covariance=-0.2)
    covariance = [[0.4, -0.2], [-0.2, 0.3]]
    error, gain = np.random.default_rng(0).multivariate_normal([1.0, 0.5], covariance, 200_000).T
    assert belief.expected_square(0.7) == pytest.approx(np.mean((error - 0.7 * gain) ** 2), rel=0.02)
