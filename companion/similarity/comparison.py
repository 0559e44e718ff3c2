"""Two identified vehicles side by side: every figure of the paper's theory, with its confidence interval."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from jaxtyping import Float

from companion.arrays import Array
from companion.errors import InputError
from companion.similarity.identification import (
    AXES,
    LEAST_MOTION_M,
    AxisEstimate,
    IdentifiedAxis,
    VehicleModel,
)
from companion.similarity.identified_lemma import CONFIDENCE, prediction_error, response_of, scaled
from companion.similarity.lemma import Lemma1, PredictionError, lemma_1
from companion.similarity.measure import Similarity, similarity
from companion.similarity.moments import SAMPLE_TIME_S
from companion.similarity.nu_gap import TransferFunction, nu_gap
from companion.similarity.remark_2 import Envelope, envelope, inverse_error_share
from companion.similarity.structure import Structure, gains_at, structure
from companion.similarity.transfer_loop import largest_stable_gain, loop_matrix, spectral_radius


class Interval(NamedTuple):
    """A figure of the whole flights, and where 95 of 100 resampled flights put it; NaN where not known."""

    value: float
    low: float = np.nan
    high: float = np.nan


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
        envelope: Remark 2's θ1 and θ2, by band of speed.
        drift_m_s: at which the target's position moves beside its velocity (m/s).
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
    envelope: Envelope
    drift_m_s: float

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
    """

    axis: str
    figures: Figures
    resampled: tuple[Figures, ...]

    def interval(self, of: Callable[[Figures], float]) -> Interval:
        """One figure with its interval, of those resampled flights that tell it."""
        value = float(of(self.figures))
        drawn = np.sort([of(each) for each in self.resampled])
        drawn = drawn[~np.isnan(drawn)]
        if len(drawn) == 0:
            return Interval(value)
        cut = round((1.0 - CONFIDENCE) / 2.0 * (len(drawn) - 1))
        return Interval(value, float(drawn[cut]), float(drawn[len(drawn) - 1 - cut]))

    def share(self, of: Callable[[Figures], bool]) -> float:
        """In how many of the resampled flights something holds."""
        return float(np.mean([of(each) for each in self.resampled])) if self.resampled else np.nan


def compare(source: VehicleModel, target: VehicleModel) -> tuple[AxisComparison, ...]:
    """North, east and down of a source and a target, those along which both moved.

    Raises:
        InputError: there are none.
    """
    axes = zip(AXES, source.axes, target.axes, strict=True)
    compared = tuple(
        _compare_axis(axis, ours, theirs) for axis, ours, theirs in axes if ours.moved and theirs.moved
    )
    if not compared:
        raise InputError(
            f"there is no axis along which both moved by {LEAST_MOTION_M:g} m (standard deviation): "
            "fly both in all three"
        )
    return compared


def _compare_axis(axis: str, source: IdentifiedAxis, target: IdentifiedAxis) -> AxisComparison:
    scale = np.sqrt((source.spread**2 + target.spread**2) / 2.0)
    scale[scale == 0.0] = 1.0
    degree = max(structure(source.model).relative_degree, structure(target.model).relative_degree)
    prediction = prediction_error(gains_at(scaled(source.model.system, scale), degree), target, scale, degree)

    def figures(ours: AxisEstimate, theirs: AxisEstimate) -> Figures:
        return _figures(ours, theirs, target, scale, prediction)

    return AxisComparison(
        axis,
        figures(source.estimate, target.estimate),
        tuple(map(figures, source.resampled, target.resampled)),
    )


def _figures(
    source: AxisEstimate,
    target: AxisEstimate,
    flown: IdentifiedAxis,
    scale: Float[Array, "3"],
    prediction: PredictionError,
) -> Figures:
    models = source.model, target.model
    of_source, of_target = map(structure, models)
    degree = max(of_source.relative_degree, of_target.relative_degree)
    ours, theirs = (scaled(each.system, scale) for each in models)
    source_gains, target_gains = gains_at(ours, degree), gains_at(theirs, degree)
    return Figures(
        source=of_source,
        target=of_target,
        s=similarity(source_gains, target_gains),
        nu_gap=nu_gap(*(TransferFunction.of(m.system, m.delay_s / SAMPLE_TIME_S) for m in models)),
        lemma=lemma_1(source_gains, target_gains, response_of(theirs), prediction),
        exact_gain=1.0 / target_gains.input,
        loop_radius=spectral_radius(loop_matrix(source_gains, theirs, target_gains, 0.0)),
        stable_gain=largest_stable_gain(source_gains, theirs, target_gains),
        inverse_error=inverse_error_share(
            *models, degree, np.tensordot(flown.shares, flown.second_moments, axes=1)
        ),
        envelope=envelope(source, target, flown, degree),
        drift_m_s=target.drift_m_s,
    )
