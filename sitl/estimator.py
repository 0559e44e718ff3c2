"""What the firmware believes: the truth of a moment ago, with first-order Gauss-Markov noise and wander."""

import math
from typing import NamedTuple

import numpy as np
from jaxtyping import Float, Int

from sitl.arrays import Array, Quaternion, Vec3
from sitl.compiled import compiled
from sitl.estimator_errors import EstimatorErrors, Level
from sitl.quaternion import from_rotation_vector, multiply

STEPS_PER_S = 1000
CONTENT = 0.1
"""A test ratio of an estimator that is content."""

_Channels = Float[Array, "4"]
_Errors = Float[Array, "4 3"]
_Steps = Int[np.ndarray[tuple[int, ...], np.dtype[np.int64]], "4"]


class Estimator(NamedTuple):
    """Errors of position, velocity, attitude and rates (rows 0 to 3), and the estimate they make.

    Attributes:
        noise: current noise, a row a channel: m, m/s, rad, rad/s.
        noise_keep: share of the noise that survives a draw, exp(-period / correlation time).
        noise_fresh: standard deviation of what is added at a draw.
        period: steps between draws.
        wander, wander_rate, wander_level: current wander, 1 / correlation time (1/s), standard deviation.
        delay: age of the truth that the errors are added to, in steps.
        past: the newest true motions, a ring by step.
        jump: how position and velocity jumped at the last reset (m, m/s).
        resets: how often there was one.
        offset, turn: what faults add to position and velocity (m, m/s) and to the heading (rad).
        test_ratios: of velocity and heading, as an EKF tells them: from 1 on it refuses its sensors.
        gps: where the GPS receiver has the vehicle: the truth, as old as the estimated position.
        position, velocity, attitude, rates: the estimate, NED, SI.
    """

    noise: _Errors
    noise_keep: _Channels
    noise_fresh: _Errors
    period: _Steps
    wander: _Errors
    wander_rate: _Channels
    wander_level: _Errors
    delay: _Steps
    past: Float[Array, "m 13"]
    jump: Float[Array, "2 3"]
    resets: Int[np.ndarray[tuple[int, ...], np.dtype[np.int64]], "1"]
    offset: Float[Array, "2 3"]
    turn: Float[Array, "1"]
    test_ratios: Float[Array, "2"]
    gps: Vec3
    position: Vec3
    velocity: Vec3
    attitude: Quaternion
    rates: Vec3


def estimator(
    errors: EstimatorErrors,
    motion: Float[Array, "13"],
    noise_rng: np.random.Generator,
    wander_rng: np.random.Generator,
) -> Estimator:
    """An estimator of a vehicle that is in the state `motion`, its errors in their stationary state."""
    channels = (errors.position, errors.velocity, errors.attitude, errors.rates)
    noise_level = _rows(
        errors.position.noise_m,
        errors.velocity.noise_m_s,
        np.radians(errors.attitude.noise_deg),
        np.radians(errors.rates.noise_deg_s),
    )
    wander_level = _rows(
        errors.position.wander_m,
        errors.velocity.wander_m_s,
        np.radians(errors.attitude.wander_deg),
        np.radians(errors.rates.wander_deg_s),
    )
    period = np.array([round(STEPS_PER_S / channel.rate_hz) for channel in channels], dtype=np.int64)
    delay = np.array([round(STEPS_PER_S * channel.delay_s) for channel in channels], dtype=np.int64)
    with np.errstate(divide="ignore"):
        keep = np.exp(-period / STEPS_PER_S / np.array([channel.correlation_time_s for channel in channels]))
    estimate = Estimator(
        noise=noise_level * noise_rng.standard_normal((4, 3)),
        noise_keep=keep,
        noise_fresh=noise_level * np.sqrt(1.0 - keep**2)[:, None],
        period=period,
        wander=wander_level * wander_rng.standard_normal((4, 3)),
        wander_rate=np.array([1.0 / channel.wander_time_s for channel in channels]),
        wander_level=wander_level,
        delay=delay,
        past=np.tile(motion, (int(delay.max()) + 1, 1)),
        jump=np.zeros((2, 3)),
        resets=np.zeros(1, dtype=np.int64),
        offset=np.zeros((2, 3)),
        turn=np.zeros(1),
        test_ratios=np.full(2, CONTENT),
        gps=np.zeros(3),
        position=np.zeros(3),
        velocity=np.zeros(3),
        attitude=np.zeros(4),
        rates=np.zeros(3),
    )
    compose(estimate, 0, motion)
    return estimate


def _rows(*levels: Level | Float[Array, "..."]) -> _Errors:
    return np.array([np.broadcast_to(np.asarray(level, dtype=float), 3) for level in levels])


def reset(estimate: Estimator, rng: np.random.Generator) -> None:
    """Let the wander of position and velocity start anew; the estimate jumps at once."""
    fresh = estimate.wander_level[:2] * rng.standard_normal((2, 3))
    jump = fresh - estimate.wander[:2]
    estimate.wander[:2] = fresh
    announce(estimate, jump)


def announce(estimate: Estimator, jump: Float[Array, "2 3"]) -> None:
    """Let position and velocity jump at once by what their errors have just changed by (m, m/s)."""
    estimate.jump[:] = jump
    estimate.position[:] += jump[0]
    estimate.velocity[:] += jump[1]
    estimate.resets[0] += 1


@compiled
def wander(estimate: Estimator, noise: _Errors, dt: float) -> None:
    """Move the wander on by `dt` (s): w ← φ w + σ √(1 − φ²) n, exact for any step."""
    for channel in range(4):
        keep = math.exp(-dt * estimate.wander_rate[channel])
        fresh = math.sqrt(1.0 - keep**2)
        for axis in range(3):
            estimate.wander[channel, axis] = (
                keep * estimate.wander[channel, axis]
                + fresh * estimate.wander_level[channel, axis] * noise[channel, axis]
            )


@compiled
def draw(estimate: Estimator, step: int, noise: Float[Array, "12"]) -> None:
    """Move on the noise that is due at this step, in the same way."""
    for channel in range(4):
        if step % estimate.period[channel] == 0:
            for axis in range(3):
                estimate.noise[channel, axis] = (
                    estimate.noise_keep[channel] * estimate.noise[channel, axis]
                    + estimate.noise_fresh[channel, axis] * noise[3 * channel + axis]
                )


@compiled
def compose(estimate: Estimator, step: int, motion: Float[Array, "13"]) -> None:
    """The estimate at this step from the true motion, its past and the present errors."""
    past, noise, slow = estimate.past, estimate.noise, estimate.wander
    offset, size = estimate.offset, past.shape[0]
    for i in range(13):
        past[step % size, i] = motion[i]
    position = past[(step - estimate.delay[0]) % size]
    velocity = past[(step - estimate.delay[1]) % size]
    attitude = past[(step - estimate.delay[2]) % size]
    rates = past[(step - estimate.delay[3]) % size]
    for axis in range(3):
        estimate.gps[axis] = position[axis]
        estimate.position[axis] = position[axis] + noise[0, axis] + slow[0, axis] + offset[0, axis]
        estimate.velocity[axis] = velocity[3 + axis] + noise[1, axis] + slow[1, axis] + offset[1, axis]
        estimate.rates[axis] = rates[10 + axis] + noise[3, axis] + slow[3, axis]
    tilted = multiply(attitude[6:10], from_rotation_vector(noise[2] + slow[2]))
    if estimate.turn[0] != 0.0:
        tilted = multiply(from_rotation_vector(np.array((0.0, 0.0, estimate.turn[0]))), tilted)
    for i in range(4):
        estimate.attitude[i] = tilted[i]
