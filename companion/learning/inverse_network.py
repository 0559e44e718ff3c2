"""The inverse network: desired motion in, reference out (u1, Eqn. dnnMapping), on numpy alone."""

from dataclasses import dataclass
from typing import Annotated, NamedTuple, TypeAlias

import numpy as np
from jaxtyping import Float
from pydantic import BaseModel, ConfigDict, Field, NonNegativeFloat, PositiveFloat, PositiveInt

from companion.arrays import Array
from companion.learning.features import Preview

Array32: TypeAlias = np.ndarray[tuple[int, ...], np.dtype[np.float32]]

LEAST_SPREAD = 0.02
"""Standard deviation (m, m/s, rad, rad/s) under which an input is noise: it tells the network nothing."""

FARTHEST_INPUT = 4.0
"""Inputs are clipped to this many standard deviations about their mean in training."""


class Scaling(NamedTuple):
    """Mean and scale of each feature: (value − mean) / scale is what the network sees.

    The scale of a feature without information is infinite, which makes zero of any value it may take.
    """

    mean: Float[Array32, " d"]
    scale: Float[Array32, " d"]


class Layer(NamedTuple):
    """One affine map: inputs @ weight + bias."""

    weight: Float[Array32, "inputs outputs"]
    bias: Float[Array32, " outputs"]


def input_scaling(samples: Float[Array, "n d"]) -> Scaling:
    """Standardisation of inputs; one that varied by less than `LEAST_SPREAD` in training is dropped.

    Dividing by that little would turn a yaw of 0.01 rad, never seen in training, into a thrown setpoint.
    """
    spread = samples.std(axis=0)
    scale = np.where(spread < LEAST_SPREAD, np.inf, spread)
    return Scaling(samples.mean(axis=0).astype(np.float32), scale.astype(np.float32))


def output_scaling(samples: Float[Array, "n d"]) -> Scaling:
    """Standardisation of outputs; one that hardly varied keeps its unit (scale 1)."""
    spread = samples.std(axis=0)
    scale = np.where(spread < LEAST_SPREAD, 1.0, spread)
    return Scaling(samples.mean(axis=0).astype(np.float32), scale.astype(np.float32))


def normalised(inputs: Float[Array, "*n d"], scaling: Scaling) -> Float[Array32, "*n d"]:
    """What the network sees of its inputs: standardised, and clipped to `FARTHEST_INPUT`."""
    standardised = (inputs - scaling.mean) / scaling.scale
    clipped = np.minimum(np.maximum(standardised, -FARTHEST_INPUT), FARTHEST_INPUT)
    single: Float[Array32, "*n d"] = clipped.astype(np.float32)
    return single


def propagated(inputs: Float[Array32, "*n d"], layers: tuple[Layer, ...]) -> Float[Array32, "*n m"]:
    """What a network of rectified linear units makes of standardised inputs; standardised as well."""
    activation = inputs
    for weight, bias in layers[:-1]:
        activation = np.dot(activation, weight)
        activation += bias
        np.maximum(activation, 0.0, out=activation)
    weight, bias = layers[-1]
    outputs: Float[Array32, "*n m"] = np.dot(activation, weight) + bias
    return outputs


Measured: TypeAlias = tuple[float, float, float]
"""A figure, and where its 95 % confidence interval begins and ends."""


class AxisLoop(BaseModel):
    """How an axis of the vehicle answers references, by a linear model of its flights.

    y(k+r) = 𝒜 x(k) + ℬ u(k) (the paper, Eqn. inputOuputLinear), x being position (m), velocity (m/s) and
    acceleration (m/s²), u the position reference that all references together amount to (m).

    Attributes:
        step_s: from k to k + 1 (s).
        delay_s: dead time until u begins to act (s).
        relative_degree: r, beyond the dead time.
        minimum_phase: whether the model's inverse is stable.
        state_gain, input_gain: 𝒜 and ℬ.
    """

    model_config = ConfigDict(frozen=True, extra="forbid")

    step_s: PositiveFloat
    delay_s: NonNegativeFloat
    relative_degree: PositiveInt
    minimum_phase: bool
    state_gain: tuple[Measured, Measured, Measured]
    input_gain: Measured


AxisLoops: TypeAlias = tuple[AxisLoop, AxisLoop, AxisLoop]
"""North, east, down."""


class ModelCard(BaseModel):
    """What a model is: enough to use it rightly, and to know where it comes from.

    Attributes:
        inputs: names of its inputs, in their order (`features.INVERSE_INPUTS`).
        outputs: names of its outputs, in their order (`features.INVERSE_OUTPUTS`, or `ACCELERATING_OUTPUTS`).
        preview: how far ahead the desired trajectory is read.
        sample_time_s: time between two samples of the training data (s).
        vehicle: what flew the training data.
        data_sha256: digest of the training samples.
        data_seconds: duration of the training flights (s).
        data_flights: their number.
        seed: of the training.
        held_out_rms: error on the part of the flight that was kept from training, for each output
            (m, m/s, m/s²).
        lookahead_s: constant time by which the flown position lagged behind a reference without acceleration
            (s); None where none was flown.
        loops: the vehicle's linear model; None where its flight gave none.
        software: version that trained it.
    """

    model_config = ConfigDict(frozen=True, extra="forbid")

    inputs: tuple[str, ...]
    outputs: tuple[str, ...]
    preview: Preview
    sample_time_s: PositiveFloat
    vehicle: str
    data_sha256: Annotated[str, Field(pattern="^[0-9a-f]{64}$")]
    data_seconds: NonNegativeFloat
    data_flights: PositiveInt = 1
    seed: int
    held_out_rms: tuple[NonNegativeFloat, ...]
    lookahead_s: NonNegativeFloat | None
    loops: AxisLoops | None = None
    software: str


@dataclass(frozen=True, eq=False)
class InverseNetwork:
    """A feed-forward network of rectified linear units, with the scaling of what goes in and comes out.

    Attributes:
        card: what it is.
        layers: its affine maps, first to last.
        input_scaling, output_scaling: standardisation on the training data.
    """

    card: ModelCard
    layers: tuple[Layer, ...]
    input_scaling: Scaling
    output_scaling: Scaling

    def __call__(self, inputs: Float[Array, "*n 12"]) -> Float[Array, "*n m"]:
        """The outputs of the card for I1, of one sample or of many; NaN where an input is NaN."""
        mean, scale = self.output_scaling
        outputs = propagated(normalised(inputs, self.input_scaling), self.layers) * scale + mean
        return outputs.astype(np.float64)
