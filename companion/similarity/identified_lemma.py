"""What Lemma 1 asks of a target, from the model that was identified from its flight."""

from collections.abc import Sequence

import numpy as np
from jaxtyping import Float

from companion.arrays import Array
from companion.errors import InputError
from companion.similarity.identification import IdentifiedAxis
from companion.similarity.lemma import PredictionError, StateResponse, state_response
from companion.similarity.linear_system import Gains, LinearSystem
from companion.similarity.structure import gains_at

CONFIDENCE = 0.95


def scaled(system: LinearSystem, scale: Float[Array, "3"]) -> LinearSystem:
    """The system with each state in units of `scale`, input and output in that of the position."""
    return LinearSystem(
        system.A / scale[:, None] * scale, system.B / scale * scale[0], system.C * scale / scale[0]
    )


def response_of(system: LinearSystem) -> StateResponse:
    """L1 and L2; infinite where (A1) fails."""
    try:
        return state_response(system)
    except InputError:
        return StateResponse(np.inf, np.inf)


def prediction_error(
    source: Gains, target: IdentifiedAxis, scale: Float[Array, "3"], degree: int
) -> PredictionError:
    """β1, β2 and β3 of (A5) for an online module that knows the target as well as its flight tells.

    e_p* = y_d − 𝒜_t x − ℬ_t u1 with u1 = (y_d − 𝒜_s x)/ℬ_s. Wrong by δ𝒜 and δℬ, a module predicts it wrong by
    (δℬ/ℬ_s) y_d + (δ𝒜 − δℬ 𝒜_s/ℬ_s) x, and by what no model foresees: bounds of 95 of 100 resamples.

    Args:
        source: 𝒜_s and ℬ_s at that `degree`, for states in units of `scale`.
        target: as it was identified, in m, m/s and m/s².
        scale: of position, velocity and acceleration.
        degree: the relative degree r.
    """
    known = gains_at(scaled(target.model.system, scale), degree)
    wrong = [gains_at(scaled(each.system, scale), degree) for each in target.resamples]
    beta_1 = _upper([abs((each.input - known.input) / source.input) for each in wrong])
    beta_2 = _upper([_state_error(each, known, source) for each in wrong])
    added = np.zeros((3, 3))
    added[1:, 1:] = target.model.noise
    powers = [target.model.system.C @ np.linalg.matrix_power(target.model.system.A, i) for i in range(degree)]
    variance = sum(float(power @ added @ power) for power in powers)
    return PredictionError(beta_1, beta_2, beta_3=1.96 * float(np.sqrt(variance)) / float(scale[0]))


def _state_error(wrong: Gains, known: Gains, source: Gains) -> float:
    off = (wrong.state - known.state) - (wrong.input - known.input) * source.state / source.input
    return float(np.linalg.norm(off))


def _upper(values: Sequence[float]) -> float:
    return float(np.quantile(values, CONFIDENCE)) if values else 0.0
