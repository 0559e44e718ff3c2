"""Two identified vehicles side by side: every figure of the paper's theory, with its confidence interval."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from jaxtyping import Float

from companion.arrays import Array
from companion.errors import InputError
from companion.similarity.identification import AXES, AxisModel, IdentifiedAxis, VehicleModel
from companion.similarity.lemma import Lemma1, PredictionError, StateResponse, lemma_1, state_response
from companion.similarity.linear_system import Gains, LinearSystem
from companion.similarity.measure import Similarity, similarity
from companion.similarity.moments import SAMPLE_TIME_S
from companion.similarity.nu_gap import TransferFunction, nu_gap
from companion.similarity.remark_2 import Envelope, envelope, inverse_error_share
from companion.similarity.structure import Structure, gains_at, structure
from companion.similarity.transfer_loop import largest_stable_gain, loop_matrix, spectral_radius

CONFIDENCE = 0.95


class Interval(NamedTuple):
    """A figure of the whole flights, and where 95 of 100 resampled flights put it."""

    value: float
    low: float
    high: float


@dataclass(frozen=True, eq=False)
class Figures:
    """What two models of one axis say of each other; states scaled alike, by how far both vehicles moved.

    Attributes:
        source, target: their structure, relative degree and zeros.
        s: S1 and S2.
        nu_gap: between the models, dead times included.
        lemma: the terms of Lemma 1.
        exact_gain: α* = 1/ℬ_t, with which a right prediction gives exact tracking.
        loop_radius: spectral radius of the target under the source's inverse alone (α = 0).
        stable_gain: α up to which that loop, with the online module, is stable.
        inverse_error: RMS error that the source's inverse leaves on the target, over its RMS tracking error.
    """

    source: Structure
    target: Structure
    s: Similarity
    nu_gap: float
    lemma: Lemma1
    exact_gain: float
    loop_radius: float
    stable_gain: float
    inverse_error: float

    @property
    def same_relative_degree(self) -> bool:
        """(A2)(i): both answer equally many steps later, with dead times less than a step apart."""
        same = self.source.relative_degree == self.target.relative_degree
        return same and abs(self.source.delay_s - self.target.delay_s) < SAMPLE_TIME_S

    @property
    def a2_holds(self) -> bool:
        """(A2): equal relative degrees, and both minimum phase."""
        return self.same_relative_degree and self.source.minimum_phase and self.target.minimum_phase


@dataclass(frozen=True, eq=False)
class AxisComparison:
    """One axis of two vehicles.

    Attributes:
        axis: north, east or down.
        figures: of the whole flights.
        resampled: of pairs of resampled flights.
        envelope: Remark 2's θ1 and θ2, by band of speed.
        drift_m_s: at which the target's position moves beside its velocity (m/s).
    """

    axis: str
    figures: Figures
    resampled: tuple[Figures, ...]
    envelope: Envelope
    drift_m_s: float

    def interval(self, of: Callable[[Figures], float]) -> Interval:
        """One figure with its interval; the interval is not known (NaN) without resamples."""
        value = float(of(self.figures))
        if not self.resampled:
            return Interval(value, np.nan, np.nan)
        drawn = np.sort([of(each) for each in self.resampled])
        cut = round((1.0 - CONFIDENCE) / 2.0 * (len(drawn) - 1))
        return Interval(value, float(drawn[cut]), float(drawn[len(drawn) - 1 - cut]))

    def share(self, of: Callable[[Figures], bool]) -> float:
        """In how many of the resampled flights something holds."""
        return float(np.mean([of(each) for each in self.resampled])) if self.resampled else np.nan


def compare(source: VehicleModel, target: VehicleModel) -> tuple[AxisComparison, ...]:
    """North, east and down of a source and a target."""
    return tuple(
        _compare_axis(axis, ours, theirs)
        for axis, ours, theirs in zip(AXES, source.axes, target.axes, strict=True)
    )


def _compare_axis(axis: str, source: IdentifiedAxis, target: IdentifiedAxis) -> AxisComparison:
    scale = np.sqrt((source.spread**2 + target.spread**2) / 2.0)
    scale[scale == 0.0] = 1.0
    degree = max(structure(source.model).relative_degree, structure(target.model).relative_degree)
    prediction = _prediction_error(source.model, target, scale, degree)
    moments = np.tensordot(target.shares, target.second_moments, axes=1)

    def figures(ours: AxisModel, theirs: AxisModel) -> Figures:
        return _figures(ours, theirs, scale, prediction, moments)

    return AxisComparison(
        axis,
        figures(source.model, target.model),
        tuple(map(figures, source.resamples, target.resamples)),
        envelope(source, target, degree),
        target.drift_m_s,
    )


def _figures(
    source: AxisModel,
    target: AxisModel,
    scale: Float[Array, "3"],
    prediction: PredictionError,
    moments: Float[Array, "6 6"],
) -> Figures:
    of_source, of_target = structure(source), structure(target)
    degree = max(of_source.relative_degree, of_target.relative_degree)
    ours, theirs = (scaled(each.system, scale) for each in (source, target))
    source_gains, target_gains = gains_at(ours, degree), gains_at(theirs, degree)
    return Figures(
        source=of_source,
        target=of_target,
        s=similarity(source_gains, target_gains),
        nu_gap=nu_gap(*(TransferFunction.of(m.system, m.delay_s / SAMPLE_TIME_S) for m in (source, target))),
        lemma=lemma_1(source_gains, target_gains, _response(theirs), prediction),
        exact_gain=1.0 / target_gains.input,
        loop_radius=spectral_radius(loop_matrix(source_gains, theirs, target_gains, 0.0)),
        stable_gain=largest_stable_gain(source_gains, theirs, target_gains),
        inverse_error=inverse_error_share(source, target, degree, moments),
    )


def scaled(system: LinearSystem, scale: Float[Array, "3"]) -> LinearSystem:
    """The system with each state in units of `scale`, input and output in that of the position."""
    return LinearSystem(
        system.A / scale[:, None] * scale, system.B / scale * scale[0], system.C * scale / scale[0]
    )


def _response(system: LinearSystem) -> StateResponse:
    """L1 and L2; infinite where (A1) fails."""
    try:
        return state_response(system)
    except InputError:
        return StateResponse(np.inf, np.inf)


def _prediction_error(
    source: AxisModel, target: IdentifiedAxis, scale: Float[Array, "3"], degree: int
) -> PredictionError:
    """β1, β2 and β3 of (A5) for an online module that knows the target as well as its flight tells.

    e_p* = y_d − 𝒜_t x − ℬ_t u1 with u1 = (y_d − 𝒜_s x)/ℬ_s. Wrong by δ𝒜 and δℬ, a module predicts it wrong by
    (δℬ/ℬ_s) y_d + (δ𝒜 − δℬ 𝒜_s/ℬ_s) x, and by what no model foresees: bounds of 95 of 100 resamples.
    """
    ours, theirs = scaled(source.system, scale), scaled(target.model.system, scale)
    of_source, known = gains_at(ours, degree), gains_at(theirs, degree)
    wrong = [gains_at(scaled(each.system, scale), degree) for each in target.resamples]
    beta_1 = _upper([abs((each.input - known.input) / of_source.input) for each in wrong])
    beta_2 = _upper([_state_error(each, known, of_source) for each in wrong])
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
