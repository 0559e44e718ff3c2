import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from sitl.firmware.px4_filters import LowPass2, blend, low_pass_2

DT = 1e-3


def response(f: LowPass2, frequency_hz: float) -> float:
    """Amplification of a sine."""
    z = np.exp(-2j * math.pi * frequency_hz * DT)
    return float(abs((f.b0 + f.b1 * z + f.b2 * z**2) / (1.0 + f.a1 * z + f.a2 * z**2)))


@given(st.floats(1.0, 400.0))
def test_second_order_low_pass_halves_the_power_at_its_cutoff(cutoff_hz: float) -> None:
    f = low_pass_2(cutoff_hz, DT)
    assert response(f, 0.0) == pytest.approx(1.0)
    assert response(f, cutoff_hz) == pytest.approx(math.sqrt(0.5))
    assert response(f, 500.0) == pytest.approx(0.0, abs=1e-9)


@pytest.mark.parametrize("cutoff_hz", [0.0, 500.0, 1000.0])
def test_no_second_order_filter_at_no_cutoff_and_beyond_half_the_sample_rate(cutoff_hz: float) -> None:
    assert response(low_pass_2(cutoff_hz, DT), 321.0) == 1.0


def test_first_order_low_pass_takes_its_time_constant() -> None:
    left = 1.0
    for _ in range(100):
        left *= 1.0 - blend(1.0 / (2.0 * math.pi * 0.1), DT)
    assert left == pytest.approx(math.exp(-1.0), rel=0.01)
    assert blend(0.0, DT) == 1.0
