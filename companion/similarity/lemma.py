"""Lemma 1 of the paper: a bound on the online module's gain under which the state stays bounded.

It is sufficient, and often vacuous: in the paper's own example L1 is 5.9 and ‖𝒜_s/ℬ_s‖ 0.62, so that the
condition fails at α = 0, although the loop is stable. The exact limits of a linear loop are in
`companion.similarity.transfer_loop`.
"""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from companion.arrays import Array
from companion.errors import InputError
from companion.similarity.linear_system import Gains, LinearSystem
from companion.similarity.measure import similarity

NEGLIGIBLE = 1e-12
"""What is left of a response when it is taken to be over."""

SLOWEST_POLE = 1.0 - 1e-4
"""A system that forgets more slowly counts as one that is not stable."""


@dataclass(frozen=True)
class StateResponse:
    """‖x‖∞ ≤ L1 ‖u‖∞ + L2 ‖x0‖ of a stable system (A1); the norm of a state is Euclidean."""

    L1: float
    L2: float


@dataclass(frozen=True)
class PredictionError:
    """Bound on the online module's error (A5): Λ ≤ β1 ‖y_d(k+r)‖ + β2 ‖x(k)‖ + β3."""

    beta_1: float = 0.0
    beta_2: float = 0.0
    beta_3: float = 0.0


EXACT = PredictionError()


@dataclass(frozen=True)
class Lemma1:
    """The terms of Lemma 1 for one source and one target.

    Attributes:
        response: L1 and L2 of the target.
        prediction: β1, β2 and β3 of the online module.
        S1_size, S2_norm: |S1| and ‖S2‖.
        inverse_state_gain: ‖𝒜_s/ℬ_s‖.
        inverse_input_gain: |1/ℬ_s|.
    """

    response: StateResponse
    prediction: PredictionError
    S1_size: float
    S2_norm: float
    inverse_state_gain: float
    inverse_input_gain: float

    @property
    def beta_4(self) -> float:
        """β4 = 1 − L1 ‖𝒜_s/ℬ_s‖."""
        return 1.0 - self.response.L1 * self.inverse_state_gain

    @property
    def aggressiveness_limit(self) -> float:
        """1/‖𝒜_s/ℬ_s‖, under which L1 must be in scenario (i)."""
        return 1.0 / self.inverse_state_gain if self.inverse_state_gain > 0.0 else np.inf

    @property
    def vacuous(self) -> bool:
        """Whether the condition fails at α = 0 already, scenario (i), so that it tells nothing."""
        return self.beta_4 <= 0.0

    @property
    def largest_gain(self) -> float:
        """The condition holds for |α| under β4 / (L1 (‖S2‖ + β2)) (Eqn. condition); 0 where it is vacuous."""
        if self.vacuous:
            return 0.0
        sensitivity = self.response.L1 * (self.S2_norm + self.prediction.beta_2)
        return self.beta_4 / sensitivity if sensitivity > 0.0 else np.inf

    def holds(self, alpha: float) -> bool:
        """Whether the condition holds with that gain."""
        return self._margin(alpha) > 0.0

    def state_bound(self, alpha: float, desired: float, initial_state: float = 0.0) -> float:
        """The proof's bound on ‖x‖∞; infinite where the condition does not hold.

        Args:
            alpha: constant gain of the online module.
            desired: ‖y_d‖∞.
            initial_state: ‖x0‖.
        """
        margin = self._margin(alpha)
        if not margin > 0.0:
            return np.inf
        gain, error = abs(alpha), self.prediction
        reference = (self.inverse_input_gain + gain * (self.S1_size + error.beta_1)) * desired
        forced = self.response.L1 * (reference + gain * error.beta_3)
        return (forced + self.response.L2 * initial_state) / margin

    def _margin(self, alpha: float) -> float:
        """1 − L1 (‖𝒜_s/ℬ_s‖ + |α| ‖S2‖ + β2 |α|)."""
        return self.beta_4 - self.response.L1 * abs(alpha) * (self.S2_norm + self.prediction.beta_2)


def lemma_1(
    source: Gains, target: Gains, response: StateResponse, prediction: PredictionError = EXACT
) -> Lemma1:
    """The terms of Lemma 1; `response` is the target's."""
    s = similarity(source, target)
    return Lemma1(
        response=response,
        prediction=prediction,
        S1_size=abs(s.S1),
        S2_norm=s.S2_norm,
        inverse_state_gain=float(np.linalg.norm(source.state) / abs(source.input)),
        inverse_input_gain=1.0 / abs(source.input),
    )


def state_response(system: LinearSystem) -> StateResponse:
    """L1 and L2 of a system.

    L1 is the least of three bounds on sup ‖Σ Aⁱ B u(i)‖ over |u| ≤ 1: Σ ‖Aⁱ B‖, and the norm of the largest
    values Σ |qᵀ Aⁱ B| that coordinates q reach, those along the axes or along the Gramian's eigenvectors.
    Where all coordinates peak together, as in the paper's example, it is exact. L2 = sup ‖Aᵏ‖.

    Raises:
        InputError: the system is not stable, which violates (A1).
    """
    slowest = np.max(np.abs(system.poles))
    if slowest > SLOWEST_POLE:
        raise InputError(
            f"a pole of size {slowest:.5f}, over {SLOWEST_POLE}: not stable, which (A1) of the paper wants"
        )
    impulses = _state_impulse_response(system)
    eigenvectors = np.linalg.eigh(impulses.T @ impulses)[1]
    L1 = min(
        np.linalg.norm(impulses, axis=1).sum(),
        np.linalg.norm(np.abs(impulses).sum(axis=0)),
        np.linalg.norm(np.abs(impulses @ eigenvectors).sum(axis=0)),
    )
    return StateResponse(L1=float(L1), L2=_largest_power(system.A))


def _state_impulse_response(system: LinearSystem) -> Float[Array, "k n"]:
    """Aⁱ B, a row for each i, until nothing is left; twice as many in each round."""
    impulses, power = system.B[None], system.A
    while np.linalg.norm(power) > NEGLIGIBLE:
        impulses = np.vstack((impulses, impulses @ power.T))
        power = power @ power
    return impulses


def _largest_power(A: Float[Array, "n n"]) -> float:
    """The greatest ‖Aᵏ‖, k ≥ 0: once a power is smaller than 1, those that follow repeat smaller ones."""
    largest, power = 1.0, A
    while (size := float(np.linalg.norm(power, 2))) >= 1.0:
        largest, power = max(largest, size), power @ A
    return largest
