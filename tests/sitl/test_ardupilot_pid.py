import math

import numpy as np
import pytest

from sitl.firmware.ardupilot_pid import (
    PidGains,
    blend,
    low_pass,
    reset_pid,
    settle,
    smooth,
    update_pid,
    update_pid_xy,
)

DT = 0.0025


def test_all_terms_add_up() -> None:
    gains = PidGains(p=2.0, i=10.0, d=0.5, feed_forward=0.1)
    state = np.zeros(4)
    # Error 1 after 0: P 2, I 10 · 1 · dt, D 0.5 · 1 / dt, feed-forward 0.1 · 3.
    out = update_pid(gains, state, 3.0, 2.0, False, DT)
    assert out == pytest.approx(2.0 + 0.025 + 200.0 + 0.3)


def test_reset_leaves_no_derivative() -> None:
    gains, state = PidGains(p=0.0, i=0.0, d=1.0), np.zeros(4)
    reset_pid(state, 3.0, 2.0)
    assert update_pid(gains, state, 3.0, 2.0, False, DT) == pytest.approx(0.0)


def test_integral_is_bounded_and_shrinks_at_the_limit_of_the_actuators() -> None:
    gains, state = PidGains(p=0.0, i=100.0, i_max=0.5), np.zeros(4)
    for _ in range(10):
        update_pid(gains, state, 1.0, 0.0, False, DT)
    assert state[3] == pytest.approx(0.5)
    state[3] = 0.4
    update_pid(gains, state, 1.0, 0.0, True, DT)
    assert state[3] == pytest.approx(0.4)
    update_pid(gains, state, -1.0, 0.0, True, DT)
    assert state[3] < 0.4


def test_a_filter_passes_63_percent_in_its_time_constant() -> None:
    gains, state = PidGains(p=1.0, i=0.0, error_hz=5.0), np.zeros(4)
    steps = round(1.0 / (2.0 * math.pi * 5.0) / DT)
    out = [update_pid(gains, state, 1.0, 0.0, False, DT) for _ in range(steps)]
    assert out[-1] == pytest.approx(1.0 - math.exp(-1.0), abs=0.03)
    assert blend(0.0, DT) == 1.0


def test_plane_integral_does_not_grow_along_the_limit_but_turns() -> None:
    gains, state = PidGains(p=0.0, i=4.0, i_max=10.0), np.zeros((3, 2))
    state[2] = (1.0, 0.0)
    update_pid_xy(gains, state, (1.0, 1.0), (0.0, 0.0), (1.0, 0.0), DT)
    assert math.hypot(*state[2]) == pytest.approx(1.0)
    assert state[2, 1] > 0.0
    update_pid_xy(gains, state, (1.0, 1.0), (0.0, 0.0), (0.0, 0.0), DT)
    assert math.hypot(*state[2]) > 1.0


@pytest.mark.parametrize(("frequency_hz", "gain"), [(1.0, 1.0), (20.0, math.sqrt(0.5)), (200.0, 0.008)])
def test_low_pass_is_a_butterworth(frequency_hz: float, gain: float) -> None:
    filtered = low_pass(1, 20.0, 0.001)
    out = [smooth(filtered, 0, math.sin(2.0 * math.pi * frequency_hz * 0.001 * k)) for k in range(3000)]
    assert max(out[1000:]) == pytest.approx(gain, abs=0.01)


def test_a_settled_filter_stays() -> None:
    filtered = low_pass(2, 20.0, 0.001)
    settle(filtered, 1, -3.0)
    assert smooth(filtered, 1, -3.0) == pytest.approx(-3.0)
    assert smooth(filtered, 0, 0.0) == 0.0
