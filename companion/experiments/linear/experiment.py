"""Systems, trajectory and figures of the paper's simulation (section VI)."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

import numpy as np
from jaxtyping import Float

from companion.arrays import Array
from companion.experiments.linear.inverse import InverseNetwork, sinusoid_responses, train
from companion.experiments.linear.online import OnlineCorrection, OnlineSettings
from companion.experiments.linear.system import LinearSystem

SAMPLE_TIME_S = 1.5e-3
STEPS = 20_000

SOURCE = LinearSystem(A=np.array([[0.0, 1.0], [-0.15, 0.8]]), B=np.array([0.0, 1.0]), C=np.array([-0.2, 1.0]))
TARGET = LinearSystem(A=np.array([[0.0, 1.0], [-0.24, 1.0]]), B=np.array([0.0, 1.0]), C=np.array([-0.1, 1.0]))
AMPLIFYING_TARGET = LinearSystem(A=TARGET.A, B=1.5 * TARGET.B, C=TARGET.C)
"""The second pair's target: it answers half as strongly again to its input, so that ℬ_t ≠ ℬ_s."""


@dataclass(frozen=True, eq=False)
class Track:
    """One run: states x(k), outputs y(k) and references u(k), a row for each step."""

    states: Float[Array, "k n"]
    outputs: Float[Array, " k"]
    references: Float[Array, " k"]


@dataclass(frozen=True)
class Figures:
    """What the paper reports, of one pair.

    Attributes:
        baseline_rms, dnn_rms, dnn_gp_rms: tracking error over the whole run with its start.
        prediction_rms: predicted against exact error, from the step on which the window is full.
    """

    baseline_rms: float
    dnn_rms: float
    dnn_gp_rms: float
    prediction_rms: float


@dataclass(frozen=True, eq=False)
class Outcome:
    """The three strategies on one target.

    Attributes:
        desired: y_d(k), a value for each step.
        predicted_error: e_p(k+r) of the online module at each step k.
        exact_error: e_p*(k+r) of the true target for the same states and u1.
        alpha: the gain that the online module estimated at each step.
        window_full: the first step on which the window is full.
    """

    desired: Float[Array, " k"]
    baseline: Track
    dnn: Track
    dnn_gp: Track
    predicted_error: Float[Array, " k"]
    exact_error: Float[Array, " k"]
    alpha: Float[Array, " k"]
    window_full: int

    def figures(self) -> Figures:
        """The figures of the paper's section VI-B."""
        misprediction = (self.predicted_error - self.exact_error)[self.window_full :]
        return Figures(
            baseline_rms=rms(self.baseline.outputs - self.desired),
            dnn_rms=rms(self.dnn.outputs - self.desired),
            dnn_gp_rms=rms(self.dnn_gp.outputs - self.desired),
            prediction_rms=rms(misprediction),
        )


def desired_outputs(steps: int, *, sample_time_s: float = SAMPLE_TIME_S) -> Float[Array, " k"]:
    """The paper's trajectory at steps 0 to `steps` − 1."""
    t = sample_time_s * np.arange(steps)
    desired: Array = np.sin(2.0 * np.pi / 8.0 * t) + np.cos(2.0 * np.pi / 16.0 * t) - 1.0
    return desired


def train_source_network(*, seed: int) -> InverseNetwork:
    """The network of the paper's source system."""
    return train(*sinusoid_responses(SOURCE), seed=seed)


def track(
    system: LinearSystem,
    desired: Float[Array, " k"],
    strategy: Callable[[Float[Array, " n"], float, float], float],
    *,
    noise: float = 0.0,
    seed: int = 0,
) -> Track:
    """Run a system from rest under a strategy.

    Args:
        system: the target.
        desired: y_d(k); the run ends r steps before it does, for that is how far a strategy looks ahead.
        strategy: reference u(k) from the measured x(k), the measured y(k) and y_d(k+r).
        noise: standard deviation of the white noise on every measurement; what is returned is the truth.
        seed: of that noise.
    """
    rng = np.random.default_rng(seed)
    n, r = len(system.B), system.relative_degree
    steps = len(desired) - r
    states = np.zeros((steps + 1, n))
    references = np.zeros(steps)
    for k in range(steps):
        measured_state = states[k] + noise * rng.standard_normal(n)
        measured_output = float(system.C @ states[k] + noise * rng.standard_normal())
        references[k] = strategy(measured_state, measured_output, float(desired[k + r]))
        states[k + 1] = system.step(states[k], references[k])
    return Track(states[:-1], states[:-1] @ system.C, references)


def evaluate(
    target: LinearSystem,
    network: InverseNetwork,
    settings: OnlineSettings,
    *,
    steps: int = STEPS,
    noise: float = 0.0,
    seed: int = 0,
) -> Outcome:
    """Fly the paper's trajectory on `target` with each of the three strategies.

    Args:
        target: the system that is flown.
        network: of the source.
        settings: of the online module.
        steps: how long.
        noise: standard deviation of the measurements, the same draw for each strategy.
        seed: of the noise and of the probe.
    """
    r = target.relative_degree
    fly = partial(track, target, noise=noise, seed=seed)
    desired = desired_outputs(steps + r)
    online = OnlineCorrection(network, r, settings, seed=seed)
    dnn_gp = fly(desired, online)
    u1, predicted_error, alpha = np.array(online.corrections).T
    return Outcome(
        desired=desired[:steps],
        baseline=fly(desired, lambda _state, _output, y_d: y_d),
        dnn=fly(desired, lambda state, _output, y_d: network(state, y_d)),
        dnn_gp=dnn_gp,
        predicted_error=predicted_error,
        exact_error=desired[r:] - dnn_gp.states @ target.state_gain - target.input_gain * u1,
        alpha=alpha,
        window_full=settings.window + r - 1,
    )


def rms(values: Float[Array, " k"]) -> float:
    """The root of the mean square."""
    return float(np.sqrt(np.mean(values**2)))
