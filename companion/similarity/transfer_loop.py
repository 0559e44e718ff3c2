"""The loop of Lemma 1's proof itself: a target under the source's inverse and a constant gain.

u(k) = (1/ℬ_s + α S1) y_d(k+r) − (𝒜_s/ℬ_s + α S2) x(k), with an exact prediction. For linear systems its poles
say precisely what Lemma 1 only bounds.
"""

import numpy as np
from jaxtyping import Float
from scipy.optimize import brentq

from companion.arrays import Array
from companion.similarity.linear_system import Gains, LinearSystem
from companion.similarity.measure import similarity

MOST_GAIN = 100.0
"""Where the search for a gain that is not stable ends."""


def loop_matrix(
    source: Gains, target: LinearSystem, target_gains: Gains, alpha: float
) -> Float[Array, "n n"]:
    """A of the target's loop: x(k+1) = A x(k) + B (…) y_d(k+r)."""
    s = similarity(source, target_gains)
    return target.A - np.outer(target.B, source.state / source.input + alpha * s.S2)


def spectral_radius(matrix: Float[Array, "n n"]) -> float:
    """Size of the greatest eigenvalue: stable under 1."""
    return float(np.max(np.abs(np.linalg.eigvals(matrix))))


def largest_stable_gain(
    source: Gains, target: LinearSystem, target_gains: Gains, *, most: float = MOST_GAIN
) -> float:
    """The gain, at most `most`, up to which the loop is stable from α = 0 on; 0 if not even there."""

    def excess(alpha: float) -> float:
        return spectral_radius(loop_matrix(source, target, target_gains, alpha)) - 1.0

    gains = np.concatenate(([0.0], np.geomspace(1e-3, 1.0, 40) * most))
    unstable = np.flatnonzero([excess(float(alpha)) >= 0.0 for alpha in gains])
    if len(unstable) == 0:
        return most
    if unstable[0] == 0:
        return 0.0
    return float(brentq(excess, gains[unstable[0] - 1], gains[unstable[0]]))
