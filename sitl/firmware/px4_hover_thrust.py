"""PX4's hover-thrust estimator: which thrust carries the weight, from how the vehicle answers its thrust.

A Kalman filter with the hover thrust as its one, constant state, and a measurement noise that adapts to the
residuals. PX4's module `mc_hover_thrust_estimator`.
"""

import math

from sitl.arrays import Vec3
from sitl.firmware.px4_parameters import Px4Parameters
from sitl.vehicle import GRAVITY_M_S2

_FIRST_NOISE = 5.0
"""Variance of the measured acceleration before anything was learnt of it (m²/s⁴)."""
_NOISE_RANGE = (1.0, 400.0)
_NOISE_TIME_S = 2.0
_RESIDUAL_TIME_S = 1.0
_REJECTED_SHARE = 0.2
"""Mean of the signed test ratio, limited to ±1, from which on the estimate itself is doubted."""
_DOUBT = 1e3
_SURE_VARIANCE = 1e-3
_SETTLED_VARIANCE = 2e-6
_SURE_FOR_S = 2.0


class HoverThrust:
    """Fraction of the maximum thrust that hovering takes.

    Attributes:
        estimate: of that fraction.
    """

    def __init__(self, parameters: Px4Parameters) -> None:
        self.use(parameters)
        self.reset()

    def use(self, parameters: Px4Parameters) -> None:
        """Go by these from now on."""
        self._parameters = p = parameters
        self._lowest = min(max(p.MPC_THR_HOVER - p.HTE_THR_RANGE, 0.0), 0.8)
        self._highest = min(max(p.MPC_THR_HOVER + p.HTE_THR_RANGE, 0.2), 0.9)

    def reset(self) -> None:
        """Know nothing but MPC_THR_HOVER."""
        self.estimate = self._parameters.MPC_THR_HOVER
        self._variance = self._parameters.HTE_HT_ERR_INIT**2
        self._noise = _FIRST_NOISE
        self._mean_residual = 0.0
        self._mean_ratio = 0.0
        self._sure_s = 0.0

    def settle(self, estimate: float) -> None:
        """Have learnt this fraction, as far as it is within reach, in a long flight."""
        self.estimate = min(max(estimate, self._lowest), self._highest)
        self._variance = _SETTLED_VARIANCE
        self._noise = _NOISE_RANGE[0]
        self._sure_s = _SURE_FOR_S

    @property
    def valid(self) -> bool:
        """Whether the estimate has been certain for long enough to fly by it."""
        return self._sure_s >= _SURE_FOR_S

    def update(self, *, climb_acceleration: float, thrust: float, velocity: Vec3, dt: float) -> None:
        """Move on by `dt` (s).

        Args:
            climb_acceleration: upwards (m/s²).
            thrust: its vertical part, upwards, fraction of the maximum.
            velocity: estimated, NED (m/s); fast flight makes the measurement less trusted.
            dt: s.
        """
        p = self._parameters
        excess = max(
            abs(velocity[2]) - p.HTE_VZ_THR, math.hypot(velocity[0], velocity[1]) - p.HTE_VXY_THR, 0.0
        )
        process_noise = p.HTE_HT_NOISE**2
        self._variance += process_noise * dt**2
        gain = -GRAVITY_M_S2 * thrust / self.estimate**2
        innovation = climb_acceleration - self._expected(thrust)
        expected_variance = gain**2 * self._variance + self._noise * (1.0 + excess) ** 2
        ratio = innovation**2 / (p.HTE_ACC_GATE**2 * expected_variance)
        if ratio < 1.0:
            share = self._variance * gain / expected_variance
            self.estimate = min(max(self.estimate + share * innovation, self._lowest), self._highest)
            self._variance = min(max((1.0 - share * gain) * self._variance, 1e-10), 1.0)
        elif abs(self._mean_ratio) > _REJECTED_SHARE:
            self._variance += _DOUBT * process_noise * dt
        self._learn_noise(climb_acceleration - self._expected(thrust), gain, dt)
        blend = dt / (_RESIDUAL_TIME_S + dt)
        self._mean_ratio += blend * (math.copysign(min(ratio, 1.0), innovation) - self._mean_ratio)
        sure = self._variance < _SURE_VARIANCE and (self.valid or ratio < 1.0)
        self._sure_s = self._sure_s + dt if sure else 0.0

    def _expected(self, thrust: float) -> float:
        return GRAVITY_M_S2 * (thrust / self.estimate - 1.0)

    def _learn_noise(self, residual: float, gain: float, dt: float) -> None:
        self._mean_residual += dt / (_RESIDUAL_TIME_S + dt) * (residual - self._mean_residual)
        seen = (residual - self._mean_residual) ** 2 + gain**2 * self._variance
        noise = self._noise + dt / (_NOISE_TIME_S + dt) * (seen - self._noise)
        self._noise = min(max(noise, _NOISE_RANGE[0]), _NOISE_RANGE[1])
