"""The inverse network of the paper's simulation: 3 hidden layers of 20 tanh, from {x(k), y(k+r)} to u(k)."""

from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise
from typing import Protocol, TypeAlias

import numpy as np
from jaxtyping import Float

from companion.arrays import Array
from companion.experiments.linear.levenberg_marquardt import minimise
from companion.experiments.linear.system import LinearSystem

HIDDEN = (20, 20, 20)
TRAINING_RMS = 1e-5
"""Where training stops, as a share of the spread of u: far below what the transfer itself costs."""

Layers: TypeAlias = list[tuple[Float[Array, "o i"], Float[Array, " o"]]]


class Inverse(Protocol):
    """An inverse of a source, as the online module takes it."""

    @property
    def inputs(self) -> int:
        """How many inputs {x(k), y(k+r)} it has."""

    def linearise(self, state: Float[Array, " n"], desired_output: float) -> tuple[float, Float[Array, " d"]]:
        """The reference u1 and its derivatives with respect to the state and the desired output."""


@dataclass(frozen=True, eq=False)
class InverseNetwork:
    """A trained network; inputs and output are divided by their spread in training.

    Attributes:
        layers: weights and biases, the first layer first.
        input_scale: shape (d,).
        output_scale: unit of the output.
    """

    layers: Layers
    input_scale: Float[Array, " d"]
    output_scale: float

    @property
    def inputs(self) -> int:
        """How many inputs {x(k), y(k+r)} it has."""
        return len(self.input_scale)

    def __call__(self, state: Float[Array, " n"], desired_output: float) -> float:
        """The reference u1 that takes the source from `state` to `desired_output` r steps later."""
        return self.linearise(state, desired_output)[0]

    def linearise(self, state: Float[Array, " n"], desired_output: float) -> tuple[float, Float[Array, " d"]]:
        """The reference u1 and its derivatives with respect to the state and the desired output."""
        activations, output = _forward(self.layers, np.append(state, desired_output)[None] / self.input_scale)
        slope = self.layers[-1][0]
        for (weights, _), activation in zip(self.layers[-2::-1], activations[:0:-1], strict=True):
            slope = (slope * (1.0 - activation**2)) @ weights
        return float(output[0] * self.output_scale), slope[0] * self.output_scale / self.input_scale


@dataclass(frozen=True, eq=False)
class ExactInverse:
    """What a perfectly trained network of a linear source would be (A4 of the paper)."""

    source: LinearSystem

    @property
    def inputs(self) -> int:
        """How many inputs {x(k), y(k+r)} it has."""
        return len(self.source.B) + 1

    def __call__(self, state: Float[Array, " n"], desired_output: float) -> float:
        """The reference u1 = (y_d(k+r) − 𝒜_s x(k)) / ℬ_s."""
        return self.linearise(state, desired_output)[0]

    def linearise(self, state: Float[Array, " n"], desired_output: float) -> tuple[float, Float[Array, " d"]]:
        """The reference u1 and its derivatives with respect to the state and the desired output."""
        return float(self._slope @ np.append(state, desired_output)), self._slope

    @cached_property
    def _slope(self) -> Float[Array, " d"]:
        return np.append(-self.source.state_gain, 1.0) / self.source.input_gain


def sinusoid_responses(
    system: LinearSystem, *, samples: int = 60
) -> tuple[Float[Array, "rows n+1"], Float[Array, " rows"]]:
    """Black-box training data: {x(k), y(k+r)} and u(k) of a system excited by 25 sinusoids from rest.

    Five amplitudes, so that the outputs cover some ±4, by five frequencies, geometrically spaced from a slow
    0.05 rad per sample to 2.2, near Nyquist's π. The fast ones matter although the trajectories are slow: in
    slow motion the states and the output are proportional, and the inverse would be known on a line only.
    """
    r = system.relative_degree
    inputs, references = [], []
    for frequency in np.geomspace(0.05, 2.2, 5):
        for amplitude in np.linspace(0.4, 2.0, 5):
            reference = amplitude * np.sin(frequency * np.arange(1, samples + r + 1))
            x = system.respond(reference)
            inputs.append(np.column_stack([x[:samples], x[r : samples + r] @ system.C]))
            references.append(reference[:samples])
    return np.vstack(inputs), np.concatenate(references)


def train(inputs: Float[Array, "rows d"], targets: Float[Array, " rows"], *, seed: int) -> InverseNetwork:
    """Train the network on rows of {x(k), y(k+r)} and u(k), from random weights of that seed."""
    input_scale, output_scale = inputs.std(axis=0), float(targets.std())
    sizes = (inputs.shape[1], *HIDDEN, 1)
    scaled_inputs, scaled_targets = inputs / input_scale, targets / output_scale
    parameters = minimise(
        lambda p: _forward(_unflatten(p, sizes), scaled_inputs)[1] - scaled_targets,
        lambda p: _jacobian(_unflatten(p, sizes), scaled_inputs),
        _random_parameters(sizes, np.random.default_rng(seed)),
        tolerance=TRAINING_RMS,
    )
    return InverseNetwork(_unflatten(parameters, sizes), input_scale, output_scale)


def _random_parameters(sizes: tuple[int, ...], rng: np.random.Generator) -> Float[Array, " p"]:
    blocks = []
    for before, after in pairwise(sizes):
        blocks.append(rng.normal(0.0, 1.0 / np.sqrt(before), after * before))
        blocks.append(rng.normal(0.0, 0.3, after))
    return np.concatenate(blocks)


def _unflatten(parameters: Float[Array, " p"], sizes: tuple[int, ...]) -> Layers:
    layers: Layers = []
    for before, after in pairwise(sizes):
        weights, biases, parameters = np.split(parameters, [after * before, after * (before + 1)])
        layers.append((weights.reshape(after, before), biases))
    return layers


def _forward(
    layers: Layers, inputs: Float[Array, "rows d"]
) -> tuple[list[Float[Array, "rows h"]], Float[Array, " rows"]]:
    """What enters each layer, and the output."""
    activations = [inputs]
    for weights, biases in layers[:-1]:
        activations.append(np.tanh(activations[-1] @ weights.T + biases))
    weights, biases = layers[-1]
    return activations, (activations[-1] @ weights.T + biases)[:, 0]


def _jacobian(layers: Layers, inputs: Float[Array, "rows d"]) -> Float[Array, "rows p"]:
    """Derivatives of the output with respect to all parameters, in the order that `_unflatten` reads."""
    activations, _ = _forward(layers, inputs)
    slope = np.ones((len(inputs), 1))
    blocks = []
    for (weights, _), activation in zip(reversed(layers), reversed(activations), strict=True):
        by_weights = (slope[:, :, None] * activation[:, None, :]).reshape(len(inputs), -1)
        blocks.append(np.hstack([by_weights, slope]))
        slope = (slope @ weights) * (1.0 - activation**2)
    return np.hstack(blocks[::-1])
