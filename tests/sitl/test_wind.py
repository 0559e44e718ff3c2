import math

import numpy as np
import pytest

from sitl.arrays import Array
from sitl.conditions import WindConditions
from sitl.wind import blow, scales, second_order, wind

AT_3_M = np.array((0.0, 0.0, -3.0))
AT_REST = np.zeros(3)
FT = 0.3048


def turbulence(conditions: WindConditions, seconds: float, dt: float, seed: int = 1) -> Array:
    """Wind of a hovering vehicle at 3 m: along the mean wind, across it to the right, down."""
    rng = np.random.default_rng(seed)
    air = wind(conditions, rng)
    out = np.empty((round(seconds / dt), 3))
    for row, noise in zip(out, rng.standard_normal((len(out), 5)), strict=True):
        blow(air, AT_3_M, AT_REST, noise, dt)
        row[:] = air.now
    along = np.array((*air.along, 0.0))
    across = np.array((-air.along[1], air.along[0], 0.0))
    return np.stack((out @ along, out @ across, out[:, 2]), axis=1)


def test_still_air_is_still() -> None:
    assert not turbulence(WindConditions(), 1.0, 0.01).any()


def test_mean_wind_blows_from_its_direction() -> None:
    air = wind(WindConditions(mean_speed_m_s=4.0, from_direction_deg=90.0), np.random.default_rng(1))
    assert air.now == pytest.approx((0.0, -4.0, 0.0), abs=1e-12)


def test_scales_are_the_specification_s() -> None:
    length_uv, length_w, sigma_uv, sigma_w = scales(10.0, 100.0 * FT)
    shape = 0.177 + 0.000823 * 100.0
    assert length_w == pytest.approx(100.0 * FT)
    assert length_uv == pytest.approx(100.0 * FT / shape**1.2)
    assert sigma_w == pytest.approx(1.0)
    assert sigma_uv == pytest.approx(1.0 / shape**0.4)
    assert scales(10.0, 0.0) == scales(10.0, 3.0)


@pytest.mark.parametrize("dt", [0.01, 0.1])
def test_variance_is_the_specification_s_at_any_step(dt: float) -> None:
    conditions = WindConditions(mean_speed_m_s=8.0, from_direction_deg=30.0, w20_kn=20.0)
    samples = turbulence(conditions, 4000.0 if dt > 0.05 else 1500.0, dt)
    _, _, sigma_uv, sigma_w = scales(20.0 * 0.514444, 3.0)
    assert samples.mean(axis=0) == pytest.approx((8.0, 0.0, 0.0), abs=0.5)
    assert samples.std(axis=0) == pytest.approx((sigma_uv, sigma_uv, sigma_w), rel=0.12)


def test_autocorrelation_is_dryden_s() -> None:
    """Along: exp(-τ). Across and down: exp(-τ) (1 - τ/2), with τ in units of L / V."""
    conditions = WindConditions(mean_speed_m_s=8.0, w20_kn=20.0)
    samples = turbulence(conditions, 6000.0, 0.05)
    length_uv, length_w, _, _ = scales(20.0 * 0.514444, 3.0)
    samples -= samples.mean(axis=0)
    for axis, length in enumerate((length_uv, length_uv, length_w)):
        lag = round(length / 8.0 / 0.05)
        tau = lag * 0.05 * 8.0 / length
        series = samples[:, axis]
        correlation = (series[:-lag] @ series[lag:]) / (series @ series) * len(series) / (len(series) - lag)
        expected = math.exp(-tau) * (1.0 if axis == 0 else 1.0 - 0.5 * tau)
        assert correlation == pytest.approx(expected, abs=0.06)


def test_second_order_filter_has_the_impulse_response_of_its_transfer_function() -> None:
    """The response to one noise sample, far shorter than T, is √2 (√3 + (1 − √3) t/T) e^(−t/T) / √2."""
    d = 1e-3
    state = np.zeros(2)
    first = second_order(state, np.array((1.0, 0.0)), d)
    silence = np.zeros(2)
    response = [first] + [second_order(state, silence, d) for _ in range(3000)]
    t = d * np.arange(len(response))
    expected = (math.sqrt(3.0) + (1.0 - math.sqrt(3.0)) * t) * np.exp(-t) / math.sqrt(3.0)
    assert np.array(response) / first == pytest.approx(expected, abs=2e-3)
