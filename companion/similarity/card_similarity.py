"""S and Lemma 1 of a source of which only a model's card is at hand, against a target that has flown."""

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from companion.errors import InputError
from companion.learning.inverse_network import AxisLoop, AxisLoops
from companion.similarity.identification import AXES, LEAST_MOTION_M, IdentifiedAxis, VehicleModel
from companion.similarity.identified_lemma import prediction_error, response_of, scaled
from companion.similarity.lemma import Lemma1, lemma_1
from companion.similarity.linear_system import Gains
from companion.similarity.measure import Similarity, similarity
from companion.similarity.structure import gains_at


class CardTerms(NamedTuple):
    """What a card and a flight say of one axis; states scaled by how far the target moved.

    Attributes:
        s: S1 and S2.
        lemma: the terms of Lemma 1.
        resampled: S1 and S2 of resampled flights: how well this one tells.
    """

    s: Similarity
    lemma: Lemma1
    resampled: tuple[Similarity, ...] = ()


def card_similarity(source: AxisLoops, target: VehicleModel) -> dict[str, CardTerms]:
    """The terms of each axis along which the target moved, from the card's 𝒜_s and ℬ_s.

    ℬ_t is taken at the source's relative degree, with which its inverse works. L1 and L2 are the target's, of
    which alone Lemma 1 wants them.

    Raises:
        InputError: the target moved along no axis.
    """
    axes = zip(AXES, source, target.axes, strict=True)
    terms = {name: _of_axis(loop, axis) for name, loop, axis in axes if axis.moved}
    if not terms:
        raise InputError(f"the vehicle moved by less than {LEAST_MOTION_M:g} m: fly farther")
    return terms


def _of_axis(source: AxisLoop, target: IdentifiedAxis) -> CardTerms:
    scale = np.where(target.spread > 0.0, target.spread, 1.0)
    state = np.array([figure for figure, _, _ in source.state_gain])
    ours = Gains(state * scale / scale[0], source.input_gain[0])
    system = scaled(target.model.system, scale)
    theirs = gains_at(system, source.relative_degree)
    prediction = prediction_error(ours, target, scale, source.relative_degree)
    resampled = (gains_at(scaled(each.system, scale), source.relative_degree) for each in target.resamples)
    return CardTerms(
        similarity(ours, theirs),
        lemma_1(ours, theirs, response_of(system), prediction),
        tuple(similarity(ours, each) for each in resampled),
    )


def as_json(terms: CardTerms) -> dict[str, Any]:
    """The terms, named as in `companion similarity --json`, and the resamples; what is infinite is None."""
    s, lemma, resampled = terms
    figures = {
        "s1": s.S1,
        "s2_position": float(s.S2[0]),
        "s2_velocity": float(s.S2[1]),
        "s2_acceleration": float(s.S2[2]),
        "s2_norm": s.S2_norm,
        "l1": lemma.response.L1,
        "l2": lemma.response.L2,
        "inverse_state_gain": lemma.inverse_state_gain,
        "l1_limit": lemma.aggressiveness_limit,
        "beta_1": lemma.prediction.beta_1,
        "beta_2": lemma.prediction.beta_2,
        "beta_3": lemma.prediction.beta_3,
        "beta_4": lemma.beta_4,
        "lemma_1_alpha": lemma.largest_gain,
        "lemma_1_state": lemma.state_bound(0.0, desired=1.0),
    }
    finite = {name: figure if np.isfinite(figure) else None for name, figure in figures.items()}
    return finite | {
        "s1_resampled": [each.S1 for each in resampled],
        "s2_norm_resampled": [each.S2_norm for each in resampled],
        "scenario_i_holds": lemma.holds(0.0),
        "lemma_1_vacuous": lemma.vacuous,
    }


def in_words(axes: Mapping[str, CardTerms]) -> str:
    """S1 and S2 of each axis, with the range of resampled flights, and what Lemma 1 says of the worst."""
    said = [
        f"{axis} S1 {each.s.S1:.2f}{_range([s.S1 for s in each.resampled])}, "
        f"‖S2‖ {each.s.S2_norm:.2f}{_range([s.S2_norm for s in each.resampled])}"
        for axis, each in axes.items()
    ]
    worst = min((each.lemma for each in axes.values()), key=lambda lemma: lemma.beta_4)
    if worst.vacuous:
        bound = f"Lemma 1 vacuous (L1 ‖𝒜s/ℬs‖ = {1.0 - worst.beta_4:.3g})"
    else:
        least = min(each.lemma.largest_gain for each in axes.values())
        bound = f"Lemma 1 allows α under {least:.2g}"
    return "; ".join([*said, bound])


def _range(values: Sequence[float]) -> str:
    return f" ({min(values):.2f} to {max(values):.2f})" if values else ""
