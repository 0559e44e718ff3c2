"""The online correction under a guard that falls back to the plain reference where the learned one harms."""

from collections import deque
from typing import NamedTuple

import numpy as np
from jaxtyping import Float

from companion.arrays import Array
from companion.experiments.linear.inverse import Inverse
from companion.experiments.linear.online import Correction, OnlineModel, OnlineSettings
from companion.learning.cautious_correction import ErrorBelief

FADE_STEPS = 5
"""From the learned reference to the plain one, and back: a jump would be a kick of its own."""

TOLERANCE = 1.01
"""How much worse than plain counts as harm; where plain itself is flown, both are alike up to rounding."""


class _Expectation(NamedTuple):
    """What was expected of a step when its reference went out: the plain one's square error, and alpha."""

    desired_output: float
    plain_square: float
    alpha: float


class Guard:
    """How much of the learned reference is used, from 0 to 1; asked once a step, in order.

    It begins with the plain reference, under which a stable target stays stable, and fades the learned one in
    as long as none of three signs shows; with any of them it is faded out:

    - Predicted harm: the plain reference is expected to leave a smaller square error than the corrected one.
    - Measured harm: over the last observations, the squares of the errors that came are more than those that
      the plain reference, as the model predicted from the same states, would have left.
    - The loop gain |1 − α Ĝ| is above 1: with the gain as it is now estimated, the α that went out makes
      errors grow.
    """

    def __init__(self, relative_degree: int, *, window: int) -> None:
        self._faded_in = 0
        self._awaiting: deque[_Expectation] = deque(maxlen=relative_degree)
        self._squares: deque[tuple[float, float]] = deque(maxlen=window)

    def weigh(self, output: float, belief: ErrorBelief, plain: float, desired_output: float) -> float:
        """The weight of the learned reference at this step.

        Args:
            output: y(k) as measured.
            belief: of the error to come.
            plain: the correction that makes the plain reference of the network's.
            desired_output: y_d(k+r).
        """
        plain_square = belief.expected_square(plain)
        harmful = (
            not belief.expected_square(belief.correction) < plain_square
            or self._measured_harm(output)
            or self._overcorrected(belief.gain)
        )
        self._faded_in = max(self._faded_in - 1, 0) if harmful else min(self._faded_in + 1, FADE_STEPS)
        self._awaiting.append(_Expectation(desired_output, plain_square, belief.alpha))
        return self._faded_in / FADE_STEPS

    def _measured_harm(self, output: float) -> bool:
        if len(self._awaiting) == self._awaiting.maxlen and np.isfinite(self._awaiting[0].plain_square):
            answered = self._awaiting[0]
            self._squares.append(((output - answered.desired_output) ** 2, answered.plain_square))
        came = sum(square for square, _ in self._squares)
        return came > TOLERANCE * sum(plain for _, plain in self._squares)

    def _overcorrected(self, gain: float) -> bool:
        return bool(self._awaiting) and abs(1.0 - self._awaiting[0].alpha * gain) > 1.0


class GuardedCorrection:
    """A network, what is learned online, and the guard; called once a step, in order.

    Attributes:
        corrections: a record of each step.
        weights: the guard's, of each step.
    """

    def __init__(
        self, network: Inverse, relative_degree: int, settings: OnlineSettings, *, seed: int
    ) -> None:
        self.corrections: list[Correction] = []
        self.weights: list[float] = []
        self._model = OnlineModel(network, relative_degree, settings.new_learner(), window=settings.window)
        self._guard = Guard(relative_degree, window=settings.window)
        self._probe = settings.probe
        self._rng = np.random.default_rng(seed)

    def __call__(self, state: Float[Array, " n"], output: float, desired_output: float) -> float:
        """The reference for x(k), y(k) and y_d(k+r), as `OnlineCorrection` takes them."""
        self._model.observe(output)
        u1, belief = self._model.believe(state, desired_output)
        weight = self._guard.weigh(output, belief, desired_output - u1, desired_output)
        self.corrections.append(Correction(u1, belief.error, belief.alpha))
        self.weights.append(weight)

        learned = u1 + belief.correction
        probe = self._probe * float(self._rng.choice((-1.0, 1.0)))
        reference = weight * learned + (1.0 - weight) * desired_output + probe
        self._model.sent(state, reference)
        return reference
