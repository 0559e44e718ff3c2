"""The online module of the paper's simulation: learns from the newest observations, corrects the reference.

Remark 1 leaves two ways to predict the error. This module predicts the output y(k+r) from {x(k), u(k)} and
subtracts it from y_d(k+r), which spares the input y_d. The other way, y_d among the inputs and the error as
output, measured the same here.
"""

from collections import deque
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from jaxtyping import Float

from companion.arrays import Array
from companion.experiments.linear.inverse import InverseNetwork
from companion.learning.explicit_basis import ExplicitBasisGP, Hyperparameters, fit
from companion.learning.gaussian_process import SlidingWindow


@dataclass(frozen=True)
class OnlineSettings:
    """How the module learns.

    Attributes:
        degree: highest power of the explicit basis; 1 is {1, ξ}, the paper's is 2.
        probe: size of the random sign that is added to each reference, in its unit. Under exact tracking
            states and reference follow y_d alone and move almost along a line, so that the window no longer
            tells ∂y/∂u: tracking stays exact while e_p and alpha are wrong, their product right. A probe far
            below any error that matters tells them apart. (With the quadratic basis rounding errors do so.)
        window: observations that are kept.
    """

    degree: int = 1
    probe: float = 1e-7
    window: int = 15


PAPER_SETTINGS = OnlineSettings(degree=2, probe=0.0)


class Correction(NamedTuple):
    """One step: u = u1 + alpha predicted_error (the paper, equations of section IV-A)."""

    u1: float
    predicted_error: float
    alpha: float


class OnlineCorrection:
    """A network and what the newest observations add to it; called once a step, in order."""

    def __init__(
        self, network: InverseNetwork, relative_degree: int, settings: OnlineSettings, *, seed: int
    ) -> None:
        self.corrections: list[Correction] = []
        self._network = network
        self._settings = settings
        self._rng = np.random.default_rng(seed)
        self._hyperparameters = Hyperparameters()
        self._awaiting: deque[Float[Array, " d"]] = deque(maxlen=relative_degree)
        self._window = SlidingWindow(settings.window, inputs=len(network.input_scale), outputs=1)

    def __call__(self, state: Float[Array, " n"], output: float, desired_output: float) -> float:
        """Learn from the output of now, and give the reference for it.

        Args:
            state: x(k) as measured.
            output: y(k) as measured.
            desired_output: y_d(k+r).
        """
        if len(self._awaiting) == self._awaiting.maxlen:
            self._window.append(self._awaiting[0], np.array([output]))
        correction = self._correct(state, desired_output)
        self.corrections.append(correction)
        probe = self._settings.probe * self._rng.choice((-1.0, 1.0))
        reference = correction.u1 + correction.alpha * correction.predicted_error + probe
        self._awaiting.append(np.append(state, reference))
        return float(reference)

    def _correct(self, state: Float[Array, " n"], desired_output: float) -> Correction:
        u1, slope = self._network.linearise(state, desired_output)
        query = np.append(state, u1)
        # The network, linearised here and solved for y, is what is known of the target before it has moved:
        # y ≈ y_d + ∂y/∂ξ (ξ − query). The Gaussian process learns what is left.
        source_slope = np.append(-slope[:-1], 1.0) / slope[-1]
        # With F = y_d − ŷ, the paper's gain −(∂F/∂u1)⁻¹ is (∂ŷ/∂u1)⁻¹.
        error, gain = 0.0, source_slope[-1]
        if len(self._window):
            residual = self._fit_residual(query, desired_output, source_slope)
            error = -residual.predict(query)
            gain += residual.gradient(query)[-1]
        return Correction(u1=u1, predicted_error=error, alpha=float(1.0 / gain))

    def _fit_residual(
        self, query: Float[Array, " d"], desired_output: float, source_slope: Float[Array, " d"]
    ) -> ExplicitBasisGP:
        expected = desired_output + (self._window.inputs - query) @ source_slope
        model = fit(
            self._window.inputs,
            self._window.outputs[:, 0] - expected,
            self._settings.degree,
            self._hyperparameters.neighbourhood(),
        )
        self._hyperparameters = model.hyperparameters
        return model
