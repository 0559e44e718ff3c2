"""A trajectory as a function of time: piecewise quintic on evenly spaced knots."""

from collections.abc import Callable
from functools import lru_cache
from typing import NamedTuple, TypeAlias

import numpy as np
from jaxtyping import Float

from companion.arrays import Array, Times, Vec3, Vec3s

Motion: TypeAlias = Callable[[Times], tuple[Vec3s, Vec3s, Vec3s]]
"""Position, velocity and acceleration (m, m/s, m/s², NED) as functions of time (s)."""

# Coefficients of 1, u, …, u⁵ on [0, 1] from p, p', p'' at u = 0 and then at u = 1 (quintic Hermite).
_HERMITE = np.array(
    [
        [1.0, 0.0, 0.0, 0.0, 0.0, 0.0],
        [0.0, 1.0, 0.0, 0.0, 0.0, 0.0],
        [0.0, 0.0, 0.5, 0.0, 0.0, 0.0],
        [-10.0, -6.0, -1.5, 10.0, -4.0, 0.5],
        [15.0, 8.0, 1.5, -15.0, 7.0, -1.0],
        [-6.0, -3.0, -0.5, 6.0, -3.0, 0.5],
    ]
)
_POWERS = np.arange(6)


class Sample(NamedTuple):
    """Where the trajectory is at one instant: NED, m, m/s, m/s²."""

    position: Vec3
    velocity: Vec3
    acceleration: Vec3


class Samples(NamedTuple):
    """Where the trajectory is at a series of instants: NED, m, m/s, m/s²."""

    position: Vec3s
    velocity: Vec3s
    acceleration: Vec3s


class Trajectory:
    """A motion from time 0 to `duration_s`, at rest at its end points before and after.

    Attributes:
        name: what to call it in tables and reports.
        step_s: time between knots (s).
        coefficients: of 1, u, …, u⁵ for each segment and axis, u from 0 to 1 within the segment (m, NED).
        duration_s: time of the last knot (s).
    """

    def __init__(self, name: str, step_s: float, coefficients: Float[Array, "m 6 3"]) -> None:
        self.name = name
        self.step_s = step_s
        self.coefficients = coefficients
        self.duration_s = step_s * len(coefficients)
        # A product of the powers of u with a row of this is position, velocity and acceleration.
        self._motion = np.concatenate([self.derivative(order) for order in range(3)], axis=2)
        self._first = _at_rest(coefficients[0, 0])
        self._last = _at_rest(coefficients[-1].sum(axis=0))

    def at(self, time_s: float) -> Sample:
        """The sample at `time_s` (s), read-only; outside the trajectory, rest at its nearer end."""
        if time_s <= 0.0:
            return self._first
        if time_s >= self.duration_s:
            return self._last
        return self._between(time_s)

    @lru_cache(maxsize=32)  # noqa: B019 - one control step asks for some instants many times
    def _between(self, time_s: float) -> Sample:
        knots = time_s / self.step_s
        segment = min(int(knots), len(self._motion) - 1)
        u = knots - segment
        u2 = u * u
        motion = np.array((1.0, u, u2, u2 * u, u2 * u2, u2 * u2 * u)) @ self._motion[segment]
        motion.flags.writeable = False
        return Sample(motion[:3], motion[3:6], motion[6:])

    def sample(self, times_s: Times) -> Samples:
        """`at` for each of `times_s` (s), in any order."""
        knots = np.clip(times_s, 0.0, self.duration_s) / self.step_s
        segments = np.minimum(knots.astype(int), len(self._motion) - 1)
        powers = (knots - segments)[:, None] ** _POWERS
        motion = np.einsum("nk,nkd->nd", powers, self._motion[segments])
        motion[(times_s <= 0.0) | (times_s >= self.duration_s), 3:] = 0.0
        return Samples(motion[:, :3], motion[:, 3:6], motion[:, 6:])

    def derivative(self, order: int) -> Float[Array, "m 6 3"]:
        """The coefficients of the derivative of that order by time (m/s^order)."""
        coefficients = self.coefficients
        for _ in range(order):
            raised = _POWERS[:, None] * coefficients / self.step_s
            coefficients = np.concatenate([raised[:, 1:], np.zeros_like(raised[:, :1])], axis=1)
        return coefficients

    def moved(self, offset: Vec3) -> "Trajectory":
        """The same motion, `offset` (m, NED) away."""
        coefficients = self.coefficients.copy()
        coefficients[:, 0] += offset
        return Trajectory(self.name, self.step_s, coefficients)

    def stretched(self, factor: float) -> "Trajectory":
        """The same path, taking `factor` times as long."""
        return Trajectory(self.name, self.step_s * factor, self.coefficients)


def quintic_through(
    name: str, step_s: float, position: Vec3s, velocity: Vec3s, acceleration: Vec3s
) -> Trajectory:
    """The trajectory with this motion (NED, m, m/s, m/s²) at knots `step_s` (s) apart."""
    knots = np.stack([position, velocity * step_s, acceleration * step_s**2], axis=1)
    ends = np.concatenate([knots[:-1], knots[1:]], axis=1)
    return Trajectory(name, step_s, np.einsum("ij,mjd->mid", _HERMITE, ends))


def trajectory_of(name: str, duration_s: float, motion: Motion, step_s: float = 0.05) -> Trajectory:
    """A smooth motion from time 0 to `duration_s`, on knots at most `step_s` apart (s)."""
    segments = int(np.ceil(duration_s / step_s))
    times = np.linspace(0.0, duration_s, segments + 1)
    return quintic_through(name, duration_s / segments, *motion(times))


def _at_rest(position: Vec3) -> Sample:
    sample = Sample(position.copy(), np.zeros(3), np.zeros(3))
    for part in sample:
        part.flags.writeable = False
    return sample
