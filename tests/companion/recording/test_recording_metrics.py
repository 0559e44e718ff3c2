"""The tracking error against cases worked out by hand."""

import numpy as np
import pytest

from companion.arrays import Times, Vec3s
from companion.recording.metrics import tracking_accuracy


def climbing(time_s: Times) -> Vec3s:
    return np.column_stack([np.zeros_like(time_s), time_s, -time_s])


def test_only_states_along_the_trajectory_count() -> None:
    time_s = np.array([0.0, 1.0, 2.0, 3.0, 4.0])
    off = np.array([[9.0, 9.0, 9.0], [3.0, 0.0, 4.0], [0.0, 0.0, 0.0], [0.0, 0.0, 0.0], [9.0, 9.0, 9.0]])
    accuracy = tracking_accuracy(climbing, time_s, climbing(time_s) + off, start_s=1.0, end_s=3.0)
    assert accuracy.max_m == pytest.approx(5.0)
    assert accuracy.rms_m == pytest.approx(np.sqrt(25.0 / 3.0))
    np.testing.assert_allclose(accuracy.rms_axes_m, [np.sqrt(3.0), 0.0, np.sqrt(16.0 / 3.0)])


def test_no_state_along_the_trajectory_is_an_error() -> None:
    time_s = np.array([0.0, 1.0])
    with pytest.raises(ValueError, match="no state between"):
        tracking_accuracy(climbing, time_s, climbing(time_s), start_s=2.0, end_s=3.0)
