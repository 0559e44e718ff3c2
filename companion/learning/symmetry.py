"""Mirror symmetry: a multirotor seen in a mirror is a multirotor, which a network need not have learned.

Two upright mirrors, one that swaps north for south and one that swaps east for west, give four views of a
motion. What a network answers differently in them is its own, not the vehicle's.
"""

import numpy as np
from jaxtyping import Float

from companion.arrays import Array
from companion.learning.inverse_network import InverseNetwork

_VECTORS: Float[Array, "4 3"] = np.array(((1, 1, 1), (-1, 1, 1), (1, -1, 1), (-1, -1, 1)), dtype=float)
"""Signs of north, east, down in each view: positions, velocities, accelerations."""
_TURNS: Float[Array, "4 3"] = np.array(((1, 1, 1), (1, -1, -1), (-1, 1, -1), (-1, -1, 1)), dtype=float)
"""Of roll, pitch, yaw and their rates, which turn about those axes: a mirror turns them the other way."""
_INPUTS: Float[Array, "4 12"] = np.hstack((_VECTORS, _VECTORS, _TURNS, _TURNS))


def symmetric_answer(network: InverseNetwork, inputs: Float[Array, "12"]) -> Float[Array, " m"]:
    """What the network answers to I1 in all four views, each seen in its own mirror again, on the average.

    So a horizontal axis along which nothing is to move is not moved.

    Args:
        network: of any card.
        inputs: I1, NED (m, m/s, rad, rad/s; `features.inverse_inputs`).

    Returns:
        The outputs of its card, NED (m, m/s, and m/s² where it gives an acceleration).
    """
    answers = network(_INPUTS * inputs)
    mirrored = answers.reshape(len(_VECTORS), -1, 3) * _VECTORS[:, None, :]
    mean: Float[Array, " m"] = mirrored.mean(axis=0).reshape(-1)
    return mean
