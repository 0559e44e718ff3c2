"""Random source and target systems in the paper's form: stable, minimum phase, of equal relative degree.

How a pair is drawn, uniformly unless said:

- order n from 1 to 4, relative degree r from 1 to the lesser of n and 3, the same for both systems;
- n poles and n − r zeros, each time a real one or (where two are left, half of the time) a conjugate pair:
  real ones between −0.95 and 0.95 (zeros 0.9), pairs over the upper half of the disc of that radius;
- the gain ℬ from 0.5 to 2, logarithmically;
- sample time, which stretches the trajectory over more steps or fewer, from 8 to 80 ms, logarithmically.

Both systems are in the controllable canonical form, as the paper's are (section VI): they share the meaning
of the state. Source and target are drawn independently: most pairs are far less alike than two vehicles.
"""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Complex

from companion.similarity.linear_system import LinearSystem

LARGEST_ORDER, LARGEST_RELATIVE_DEGREE = 4, 3
LARGEST_POLE, LARGEST_ZERO = 0.95, 0.9
GAINS = (0.5, 2.0)
SAMPLE_TIMES_S = (0.008, 0.08)


@dataclass(frozen=True)
class Pair:
    """A source, a target, and the sample time at which both run."""

    source: LinearSystem
    target: LinearSystem
    sample_time_s: float


def draw_pair(seed: int, index: int) -> Pair:
    """The pair of that number in the series of that seed; it does not depend on those before it."""
    rng = np.random.default_rng((seed, index))
    order = int(rng.integers(1, LARGEST_ORDER, endpoint=True))
    relative_degree = int(rng.integers(1, min(order, LARGEST_RELATIVE_DEGREE), endpoint=True))
    return Pair(
        source=_draw_system(rng, order, relative_degree),
        target=_draw_system(rng, order, relative_degree),
        sample_time_s=_log_uniform(rng, *SAMPLE_TIMES_S),
    )


def canonical_system(
    poles: Complex[np.ndarray, " n"], zeros: Complex[np.ndarray, " n-r"], gain: float
) -> LinearSystem:
    """The controllable canonical form of gain Π(z − zero) / Π(z − pole); `gain` is ℬ.

    Args:
        poles: complex ones with their conjugates.
        zeros: likewise, fewer than poles.
        gain: ℬ, the factor of the highest powers.
    """
    order = len(poles)
    A = np.eye(order, k=1)
    A[-1] = -np.poly(poles).real[:0:-1]
    B = np.zeros(order)
    B[-1] = gain
    numerator = np.atleast_1d(np.poly(zeros)).real[::-1]
    C = np.zeros(order)
    C[: len(numerator)] = numerator
    return LinearSystem(A=A, B=B, C=C)


def _draw_system(rng: np.random.Generator, order: int, relative_degree: int) -> LinearSystem:
    return canonical_system(
        poles=_draw_roots(rng, order, LARGEST_POLE),
        zeros=_draw_roots(rng, order - relative_degree, LARGEST_ZERO),
        gain=_log_uniform(rng, *GAINS),
    )


def _draw_roots(rng: np.random.Generator, count: int, radius: float) -> Complex[np.ndarray, " {count}"]:
    roots: list[complex] = []
    while (left := count - len(roots)) > 0:
        if left > 1 and rng.random() < 0.5:
            root = radius * np.sqrt(rng.random()) * np.exp(1j * rng.uniform(0.0, np.pi))
            roots += [root, root.conjugate()]
        else:
            roots.append(rng.uniform(-radius, radius))
    return np.array(roots, dtype=complex)


def _log_uniform(rng: np.random.Generator, low: float, high: float) -> float:
    return float(np.exp(rng.uniform(np.log(low), np.log(high))))
