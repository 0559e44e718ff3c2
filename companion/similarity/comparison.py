"""Two identified vehicles side by side: every figure of the paper's theory, with its confidence interval."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from jaxtyping import Float

from companion.arrays import Array
from companion.similarity.identification import AXES, AxisModel, IdentifiedAxis, VehicleModel
from companion.similarity.identified_lemma import CONFIDENCE, prediction_error, response_of, scaled
from companion.similarity.lemma import Lemma1, PredictionError, lemma_1
from companion.similarity.measure import Similarity, similarity
from companion.similarity.moments import SAMPLE_TIME_S
from companion.similarity.nu_gap import TransferFunction, nu_gap
from companion.similarity.remark_2 import Envelope, envelope, inverse_error_share
from companion.similarity.structure import Structure, gains_at, structure
from companion.similarity.transfer_loop import largest_stable_gain, loop_matrix, spectral_radius


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
    prediction = prediction_error(gains_at(scaled(source.model.system, scale), degree), target, scale, degree)
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
        lemma=lemma_1(source_gains, target_gains, response_of(theirs), prediction),
        exact_gain=1.0 / target_gains.input,
        loop_radius=spectral_radius(loop_matrix(source_gains, theirs, target_gains, 0.0)),
        stable_gain=largest_stable_gain(source_gains, theirs, target_gains),
        inverse_error=inverse_error_share(source, target, degree, moments),
    )
