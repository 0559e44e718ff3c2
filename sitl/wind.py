"""Mean wind with Dryden turbulence (MIL-F-8785C, section 3.7: low-altitude model, below 1000 ft).

The longitudinal axis is the mean wind's direction. The forming filters are discretised exactly, so that
the variance does not depend on the step.
"""

import math
from typing import NamedTuple

import numpy as np
from jaxtyping import Float

from sitl.arrays import Array, Vec3
from sitl.compiled import compiled
from sitl.conditions import WindConditions

_M_S_PER_KN = 0.514444
_FT_PER_M = 1.0 / 0.3048
_MIN_HEIGHT_M = 3.0
_MAX_HEIGHT_M = 304.8
_MIN_AIRSPEED_M_S = 1.0


class Wind(NamedTuple):
    """Constants of a wind, and its state.

    Attributes:
        mean: NED (m/s).
        along: unit vector of the longitudinal axis, north and east.
        w20: wind speed at 20 ft (m/s).
        filters: unit-variance states: longitudinal, two lateral, two vertical.
        gust: what comes on top, NED (m/s).
        now: wind of this instant, all together, NED (m/s).
    """

    mean: Vec3
    along: Float[Array, "2"]
    w20: float
    filters: Float[Array, "5"]
    gust: Vec3
    now: Vec3


def wind(conditions: WindConditions, rng: np.random.Generator) -> Wind:
    """A wind whose turbulence is already in its stationary state."""
    to = math.radians(conditions.from_direction_deg) + math.pi
    along = np.array((math.cos(to), math.sin(to)))
    mean = np.array((*(conditions.mean_speed_m_s * along), 0.0))
    a = rng.standard_normal(5)
    # Stationary covariance of the two states of a second-order filter: 1, 1/2; 1/2, 1/2.
    filters = np.array((a[0], a[1], 0.5 * (a[1] + a[2]), a[3], 0.5 * (a[3] + a[4])))
    return Wind(mean, along, conditions.w20_kn * _M_S_PER_KN, filters, np.zeros(3), mean.copy())


@compiled
def scales(w20: float, height: float) -> tuple[float, float, float, float]:
    """Turbulence lengths (m) and intensities (m/s): horizontal, vertical, horizontal, vertical.

    MIL-F-8785C figures 10 and 11: L_w = h, L_u = L_v = h / (0.177 + 0.000823 h)^1.2, σ_w = 0.1 W20,
    σ_u = σ_v = σ_w / (0.177 + 0.000823 h)^0.4, with h in feet.
    """
    h = min(max(height, _MIN_HEIGHT_M), _MAX_HEIGHT_M)
    shape = 0.177 + 0.000823 * h * _FT_PER_M
    return h / shape**1.2, h, 0.1 * w20 / shape**0.4, 0.1 * w20


@compiled
def second_order(state: Float[Array, "2"], noise: Float[Array, "2"], d: float) -> float:
    """Advance (1 + √3 T s) / (1 + T s)² by d = dt / T, in place; returns its unit-variance output.

    With ẋ₁ = −x₁/T + √(2/T) w and ẋ₂ = (x₁ − x₂)/T the filter is (√3 x₁ + (1 − √3) x₂) / √2; the noise of
    a step has the covariance of these two integrals over it.
    """
    keep = math.exp(-d)
    q11 = 1.0 - keep**2
    q12 = 0.5 * (1.0 - keep**2 * (1.0 + 2.0 * d))
    q22 = 0.5 * (1.0 - keep**2 * (1.0 + 2.0 * d + 2.0 * d**2))
    n1 = math.sqrt(q11) * noise[0]
    n2 = q12 / q11 * n1 + math.sqrt(max(0.0, q22 - q12**2 / q11)) * noise[1]
    state[1] = keep * (state[1] + d * state[0]) + n2
    state[0] = keep * state[0] + n1
    return float((math.sqrt(3.0) * state[0] + (1.0 - math.sqrt(3.0)) * state[1]) / math.sqrt(2.0))


@compiled
def blow(air: Wind, position: Vec3, velocity: Vec3, noise: Float[Array, "5"], dt: float) -> None:
    """Advance the turbulence by `dt` (s) at the vehicle's height and airspeed; sets `air.now`."""
    if air.w20 == 0.0:
        for axis in range(3):
            air.now[axis] = air.mean[axis] + air.gust[axis]
        return
    relative = velocity - air.mean
    airspeed = max(_MIN_AIRSPEED_M_S, math.sqrt(relative[0] ** 2 + relative[1] ** 2 + relative[2] ** 2))
    length_uv, length_w, sigma_uv, sigma_w = scales(air.w20, -position[2])
    horizontal = dt * airspeed / length_uv
    x = air.filters
    keep = math.exp(-horizontal)
    x[0] = keep * x[0] + math.sqrt(1.0 - keep**2) * noise[0]
    u = sigma_uv * x[0]
    v = sigma_uv * second_order(x[1:3], noise[1:3], horizontal)
    w = sigma_w * second_order(x[3:5], noise[3:5], dt * airspeed / length_w)
    air.now[0] = air.mean[0] + u * air.along[0] - v * air.along[1] + air.gust[0]
    air.now[1] = air.mean[1] + u * air.along[1] + v * air.along[0] + air.gust[1]
    air.now[2] = air.mean[2] + w + air.gust[2]
