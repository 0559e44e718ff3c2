"""The online module of the paper's simulation: learns from the newest observations, corrects the reference.

Remark 1 leaves two ways to predict the error. This module predicts the output y(k+r) from {x(k), u(k)} and
subtracts it from y_d(k+r), which spares the input y_d. The other way, y_d among the inputs and the error as
output, measured the same here.
"""

from collections import deque
from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple, TypeAlias

import numpy as np
from jaxtyping import Float

from companion.arrays import Array
from companion.experiments.linear.inverse import Inverse
from companion.learning.cautious_correction import ErrorBelief
from companion.learning.explicit_basis import Hyperparameters, fit
from companion.learning.gaussian_process import SlidingWindow
from companion.learning.linear_process import fit_linear

Learner: TypeAlias = Callable[
    [Float[Array, "n d"], Float[Array, " n"], Float[Array, " d"], Float[Array, " d"]], ErrorBelief
]
"""What is believed of the error at a query {x, u1}: from the window's inputs ξ = {x, u}, by how much the
outputs there were above the source's, the query, and the source's ∂y/∂ξ."""


def linear_belief(
    inputs: Float[Array, "n d"],
    residuals: Float[Array, " n"],
    query: Float[Array, " d"],
    source_slope: Float[Array, " d"],
) -> ErrorBelief:
    """A learner that knows how noisy its window is: `fit_linear` on {1, ξ}.

    Before anything is seen, the target's slopes are taken to differ from the source's by about as much as
    these themselves amount to.
    """
    centre = inputs.mean(axis=0)
    size = float(np.linalg.norm(source_slope))
    reach = float(np.max(np.linalg.norm(inputs, axis=1)))
    prior = np.append(size * reach, np.full(len(query), size / np.sqrt(len(query))))
    posterior = fit_linear(np.column_stack([np.ones(len(inputs)), inputs - centre]), residuals, prior)

    here = np.append(1.0, query - centre)
    return ErrorBelief(
        error=float(-here @ posterior.mean),
        gain=float(source_slope[-1] + posterior.mean[-1]),
        error_variance=float(here @ posterior.covariance @ here),
        gain_variance=float(posterior.covariance[-1, -1]),
        covariance=float(-here @ posterior.covariance[:, -1]),
    )


class QuadraticLearner:
    """The paper's learner: a process with a quadratic basis, which takes its predictions for certain."""

    def __init__(self) -> None:
        self._hyperparameters = Hyperparameters()

    def __call__(
        self,
        inputs: Float[Array, "n d"],
        residuals: Float[Array, " n"],
        query: Float[Array, " d"],
        source_slope: Float[Array, " d"],
    ) -> ErrorBelief:
        """Fit the window, warm-started from the last one."""
        model = fit(inputs, residuals, 2, self._hyperparameters.neighbourhood())
        self._hyperparameters = model.hyperparameters
        # With F = y_d − ŷ, the paper's gain −(∂F/∂u1)⁻¹ is (∂ŷ/∂u1)⁻¹.
        return ErrorBelief(-model.predict(query), float(source_slope[-1] + model.gradient(query)[-1]))


@dataclass(frozen=True)
class OnlineSettings:
    """How the module learns.

    Attributes:
        probe: size of the random sign that is added to each reference, in its unit. Under exact tracking
            states and reference follow y_d alone and move almost along a line, so that the window no longer
            tells ∂y/∂u: tracking stays exact while e_p and alpha are wrong, their product right. A probe far
            below any error that matters tells them apart. (With the quadratic basis rounding errors do so.)
        window: observations that are kept.
        new_learner: makes what learns from them.
    """

    probe: float = 1e-7
    window: int = 30
    new_learner: Callable[[], Learner] = lambda: linear_belief


PAPER_SETTINGS = OnlineSettings(probe=0.0, window=15, new_learner=QuadraticLearner)


class OnlineModel:
    """What the newest observations say of the error to come."""

    def __init__(self, network: Inverse, relative_degree: int, learner: Learner, *, window: int) -> None:
        self._network = network
        self._learner = learner
        self._awaiting: deque[Float[Array, " d"]] = deque(maxlen=relative_degree)
        self._window = SlidingWindow(window, inputs=network.inputs, outputs=1)

    def observe(self, output: float) -> None:
        """Take the measured y(k), which answers the state and the reference of r steps ago."""
        if len(self._awaiting) == self._awaiting.maxlen:
            self._window.append(self._awaiting[0], np.array([output]))

    def believe(self, state: Float[Array, " n"], desired_output: float) -> tuple[float, ErrorBelief]:
        """The network's u1, and what is believed of the error that it leaves."""
        u1, slope = self._network.linearise(state, desired_output)
        query = np.append(state, u1)
        # The network, linearised here and solved for y, is what is known of the target before it has moved:
        # y ≈ y_d + ∂y/∂ξ (ξ − query). What is learned is what is left.
        source_slope = np.append(-slope[:-1], 1.0) / slope[-1]
        if not len(self._window):
            return u1, ErrorBelief(0.0, float(source_slope[-1]), error_variance=np.inf)
        expected = desired_output + (self._window.inputs - query) @ source_slope
        residuals = self._window.outputs[:, 0] - expected
        return u1, self._learner(self._window.inputs, residuals, query, source_slope)

    def sent(self, state: Float[Array, " n"], reference: float) -> None:
        """Remember the reference that went out."""
        self._awaiting.append(np.append(state, reference))


class Correction(NamedTuple):
    """One step: u1, the error that it was predicted to leave, and the gain of the correction."""

    u1: float
    predicted_error: float
    alpha: float


class OnlineCorrection:
    """A network and what the newest observations add to it; called once a step, in order."""

    def __init__(
        self, network: Inverse, relative_degree: int, settings: OnlineSettings, *, seed: int
    ) -> None:
        self.corrections: list[Correction] = []
        self._model = OnlineModel(network, relative_degree, settings.new_learner(), window=settings.window)
        self._probe = settings.probe
        self._rng = np.random.default_rng(seed)

    def __call__(self, state: Float[Array, " n"], output: float, desired_output: float) -> float:
        """Learn from the output of now, and give the reference for it.

        Args:
            state: x(k) as measured.
            output: y(k) as measured.
            desired_output: y_d(k+r).
        """
        self._model.observe(output)
        u1, belief = self._model.believe(state, desired_output)
        self.corrections.append(Correction(u1, belief.error, belief.alpha))
        reference = u1 + belief.correction + self._probe * float(self._rng.choice((-1.0, 1.0)))
        self._model.sent(state, reference)
        return reference
