"""Which of several networks is followed, and how one takes over from another."""

import numpy as np
from jaxtyping import Float

from companion.arrays import Array
from companion.learning.negative_transfer import faded

_LISTENING_S = 3.0
"""Of motion, before the first is chosen, and again before another is: until then none is followed."""
_BETTER = 2.0
_BETTER_M2 = 1e-6
"""By this factor, and by this much, another must lessen the mean square error more to take over."""


class Selection:
    """The network that lessens the error most; one alone is followed from the beginning.

    Attributes:
        chosen: its place, None where none is yet.
        weights: of each network, 0 to 1; they pass from one to another in a fade.
    """

    def __init__(self, count: int) -> None:
        self.chosen: int | None = 0 if count == 1 else None
        self.weights: Float[Array, " n"] = np.ones(1) if count == 1 else np.zeros(count)
        self._heard_s = 0.0

    def choose(self, gains: Float[Array, " n"], *, tells: bool, duration_s: float) -> None:
        """A step passed.

        Args:
            gains: by how much each network lessens the mean square error (m²).
            tells: whether the networks differ from the plain reference, so that they can be heard.
            duration_s: of the step.
        """
        if not len(gains):
            return
        self._heard_s += duration_s if tells else 0.0
        best = int(gains.argmax())
        rival = 0.0 if self.chosen is None else max(float(gains[self.chosen]), 0.0)
        if self._heard_s >= _LISTENING_S and gains[best] > _BETTER * rival + _BETTER_M2:
            self._heard_s = 0.0 if best != self.chosen else self._heard_s
            self.chosen = best
        target = np.zeros_like(self.weights)
        if self.chosen is not None:
            target[self.chosen] = 1.0
        self.weights = faded(self.weights, target, duration_s)
