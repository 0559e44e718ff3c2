"""From a recorded flight to the inverse network of the vehicle that flew it (the paper's "DNN Module").

Training needs torch (the `train` extra); importing this module does not.
"""

import hashlib
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from importlib.metadata import version
from typing import TypeAlias

import numpy as np
from jaxtyping import Float

from companion.arrays import Array
from companion.errors import InputError
from companion.learning.features import ACCELERATING_OUTPUTS, INVERSE_INPUTS, Preview
from companion.learning.inverse_network import (
    InverseNetwork,
    Layer,
    ModelCard,
    Scaling,
    input_scaling,
    normalised,
    output_scaling,
    propagated,
)
from companion.learning.training_data import constant_lag, displaced, training_pairs
from companion.recording.series import Recording

PREVIEW = Preview(position_s=(0.05, 0.05, 0.0), velocity_s=(0.25, 0.25, 0.12))
"""Short ones for the position, which then shows where the vehicle is beside its path, and for the velocity
about the lag of a small multirotor's attitude, which is shorter for the thrust; see docs/decisions.md."""
SAMPLE_TIME_S = 0.02

HIDDEN_LAYERS = (128, 128, 128, 128)

HELD_OUT_SHARE = 0.15
"""Of the flight: its last part."""

Progress: TypeAlias = Callable[[int, float], None]
"""Called now and then with the number of steps done and the held-out error (standardised, RMS)."""


@dataclass(frozen=True, eq=False)
class Fit:
    """What a training found.

    Attributes:
        layers: affine maps, first to last.
        input_scaling, output_scaling: standardisation on the samples trained on.
        held_out_rms: error of each output on the samples held out, in the outputs' units.
    """

    layers: tuple[Layer, ...]
    input_scaling: Scaling
    output_scaling: Scaling
    held_out_rms: Float[Array, " m"]


def train_inverse_network(
    recording: Recording,
    preview: Preview,
    sample_time_s: float,
    *,
    seed: int,
    progress: Progress | None = None,
) -> InverseNetwork:
    """Train the inverse of the vehicle that flew `recording` (Eqn. dnnMapping); same seed, same network.

    Raises:
        InputError: too little usable data, or torch is missing.
    """
    inputs, outputs = training_pairs(recording, preview, sample_time_s)
    samples = displaced(inputs, outputs, np.random.default_rng(seed))
    fit = train(*samples, seed=seed, progress=progress)
    card = ModelCard(
        inputs=INVERSE_INPUTS,
        outputs=ACCELERATING_OUTPUTS[: outputs.shape[1]],
        preview=preview,
        sample_time_s=sample_time_s,
        vehicle=recording.provenance.vehicle,
        data_sha256=hashlib.sha256(inputs.tobytes() + outputs.tobytes()).hexdigest(),
        data_seconds=len(inputs) * sample_time_s,
        seed=seed,
        held_out_rms=tuple(fit.held_out_rms.tolist()),
        lookahead_s=constant_lag(recording),
        software=version("impromptu"),
    )
    return InverseNetwork(card, fit.layers, fit.input_scaling, fit.output_scaling)


def train(
    inputs: Float[Array, "n d"],
    outputs: Float[Array, "n m"],
    *,
    seed: int,
    hidden_layers: Sequence[int] = HIDDEN_LAYERS,
    progress: Progress | None = None,
) -> Fit:
    """Fit a network of rectified linear units to samples in the order of time; deterministic, on one core.

    The last part of the flight is held out, in one piece: neighbours in time are nearly copies of each other,
    and a shuffled split would measure memory. The weights of the lowest error there are kept.

    Raises:
        InputError: torch is missing.
    """
    try:
        from companion.learning.descent import descend
    except ModuleNotFoundError as error:
        raise InputError("training needs torch: install it with `pip install 'impromptu[train]'`") from error
    kept = round(len(inputs) * (1.0 - HELD_OUT_SHARE))
    of_inputs, of_outputs = input_scaling(inputs[:kept]), output_scaling(outputs[:kept])
    x = normalised(inputs, of_inputs)
    y = ((outputs - of_outputs.mean) / of_outputs.scale).astype(np.float32)
    layers = descend((x[:kept], y[:kept]), (x[kept:], y[kept:]), hidden_layers, seed=seed, progress=progress)
    residual = (propagated(x[kept:], layers) - y[kept:]) * of_outputs.scale
    return Fit(layers, of_inputs, of_outputs, np.sqrt(np.mean(residual.astype(np.float64) ** 2, axis=0)))
