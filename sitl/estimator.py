"""What the firmware believes: the truth with first-order Gauss-Markov errors."""

import math
from typing import NamedTuple

import numpy as np
from jaxtyping import Float, Int

from sitl.arrays import Array, Quaternion, Vec3
from sitl.compiled import compiled
from sitl.conditions import EstimatorConditions
from sitl.quaternion import from_rotation_vector, multiply

STEPS_PER_S = 1000

_Channels = Float[Array, "4"]


class Estimator(NamedTuple):
    """Errors of position, velocity, attitude and rates (rows 0 to 3), and the estimate they make.

    Attributes:
        error: current error, a row a channel: m, m/s, rad, rad/s.
        keep: share of the error that survives a draw, exp(-period / correlation time).
        fresh: standard deviation of what is added at a draw.
        period: steps between draws.
        position, velocity, attitude, rates: the estimate, NED, SI.
    """

    error: Float[Array, "4 3"]
    keep: _Channels
    fresh: _Channels
    period: Int[np.ndarray[tuple[int, ...], np.dtype[np.int64]], "4"]
    position: Vec3
    velocity: Vec3
    attitude: Quaternion
    rates: Vec3


def estimator(
    conditions: EstimatorConditions, motion: Float[Array, "13"], rng: np.random.Generator
) -> Estimator:
    """An estimator of a vehicle that is in the state `motion`, its errors in their stationary state."""
    channels = (conditions.position, conditions.velocity, conditions.attitude, conditions.rates)
    sigma = np.array(
        (
            conditions.position.noise_m,
            conditions.velocity.noise_m_s,
            math.radians(conditions.attitude.noise_deg),
            math.radians(conditions.rates.noise_deg_s),
        )
    )
    period = np.array([round(STEPS_PER_S / channel.rate_hz) for channel in channels], dtype=np.int64)
    time_constant = np.array([channel.correlation_time_s for channel in channels])
    with np.errstate(divide="ignore"):
        keep = np.exp(-period / STEPS_PER_S / time_constant)
    estimate = Estimator(
        error=sigma[:, None] * rng.standard_normal((4, 3)),
        keep=keep,
        fresh=sigma * np.sqrt(1.0 - keep**2),
        period=period,
        position=np.zeros(3),
        velocity=np.zeros(3),
        attitude=np.zeros(4),
        rates=np.zeros(3),
    )
    compose(estimate, motion)
    return estimate


@compiled
def draw(estimate: Estimator, step: int, noise: Float[Array, "12"]) -> None:
    """Move on the errors that are due at this step: e ← φ e + σ √(1 − φ²) n, exact for any period."""
    for channel in range(4):
        if step % estimate.period[channel] == 0:
            for axis in range(3):
                estimate.error[channel, axis] = (
                    estimate.keep[channel] * estimate.error[channel, axis]
                    + estimate.fresh[channel] * noise[3 * channel + axis]
                )


@compiled
def compose(estimate: Estimator, motion: Float[Array, "13"]) -> None:
    """The estimate from the truth and the present errors."""
    for axis in range(3):
        estimate.position[axis] = motion[axis] + estimate.error[0, axis]
        estimate.velocity[axis] = motion[3 + axis] + estimate.error[1, axis]
        estimate.rates[axis] = motion[10 + axis] + estimate.error[3, axis]
    attitude = multiply(motion[6:10], from_rotation_vector(estimate.error[2]))
    for i in range(4):
        estimate.attitude[i] = attitude[i]
