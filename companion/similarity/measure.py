"""The paper's characterisation of similarity: S = [S1 S2] (Eqn. similarityLinearS)."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from companion.arrays import Array
from companion.similarity.linear_system import Gains


@dataclass(frozen=True, eq=False)
class Similarity:
    """S of a source and a target: 0 if and only if both lead from the same state to the same output.

    Attributes:
        S1: 1 − ℬ_t/ℬ_s, difference in the gain from input to output.
        S2: 𝒜_t − (ℬ_t/ℬ_s) 𝒜_s, difference in the gains from state to output, shape (n,).
    """

    S1: float
    S2: Float[Array, " n"]

    @property
    def S2_norm(self) -> float:
        """‖S2‖."""
        return float(np.linalg.norm(self.S2))


def similarity(source: Gains, target: Gains) -> Similarity:
    """S of two systems whose states are measured alike, and in the same scale."""
    ratio = target.input / source.input
    return Similarity(S1=1.0 - ratio, S2=target.state - ratio * source.state)
