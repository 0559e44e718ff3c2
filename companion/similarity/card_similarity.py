"""S of a source of which only a model's card is at hand, against a target that has flown."""

import numpy as np

from companion.learning.inverse_network import AxisLoop, AxisLoops
from companion.similarity.identification import IdentifiedAxis, VehicleModel
from companion.similarity.linear_system import Gains
from companion.similarity.measure import Similarity, similarity
from companion.similarity.structure import gains_at


def card_similarity(source: AxisLoops, target: VehicleModel) -> tuple[Similarity, Similarity, Similarity]:
    """S1 and S2 of north, east and down, from the card's 𝒜_s and ℬ_s; states in m, m/s and m/s².

    ℬ_t is taken at the source's relative degree, with which its inverse works.
    """
    north, east, down = (_of_axis(loop, axis) for loop, axis in zip(source, target.axes, strict=True))
    return north, east, down


def _of_axis(source: AxisLoop, target: IdentifiedAxis) -> Similarity:
    gains = Gains(np.array([figure for figure, _, _ in source.state_gain]), source.input_gain[0])
    return similarity(gains, gains_at(target.model.system, source.relative_degree))
