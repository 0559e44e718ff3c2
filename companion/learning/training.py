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
    Array32,
    AxisLoops,
    InverseNetwork,
    Layer,
    ModelCard,
    Scaling,
    input_scaling,
    normalised,
    output_scaling,
    propagated,
)
from companion.learning.training_data import (
    Samples,
    displaced,
    has_acceleration,
    joined,
    split,
    training_pairs,
)
from companion.recording.series import Recording

PREVIEW = Preview(position_s=(0.05, 0.05, 0.0), velocity_s=(0.25, 0.25, 0.12))
"""Short ones for the position, which then shows where the vehicle is beside its path, and for the velocity
about the lag of a small multirotor's attitude, which is shorter for the thrust; see docs/decisions.md."""
SAMPLE_TIME_S = 0.02

HIDDEN_LAYERS = (128, 128, 128, 128)

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
    recordings: Sequence[Recording],
    preview: Preview,
    sample_time_s: float,
    *,
    seed: int,
    lookahead_s: float | None = None,
    loops: AxisLoops | None = None,
    progress: Progress | None = None,
) -> InverseNetwork:
    """Train the inverse of the vehicle that flew `recordings` (Eqn. dnnMapping); same seed, same network.

    Where some were sent an acceleration, those alone teach. No sample reaches from one flight into another.

    Args:
        recordings: flights of one vehicle.
        preview: how far ahead the network is to look.
        sample_time_s: between two samples (s).
        seed: of everything random.
        lookahead_s: for the card (s).
        loops: for the card.
        progress: told how far the training is.

    Raises:
        InputError: too little usable data, flights of several vehicles, or torch is missing.
    """
    vehicle = _common_vehicle(recordings)
    teaching = list(filter(has_acceleration, recordings)) or recordings
    flights = [training_pairs(recording, preview, sample_time_s) for recording in teaching]
    rng = np.random.default_rng(seed)
    fit = train(*split([displaced(flight, rng) for flight in flights]), seed=seed, progress=progress)
    inputs, outputs = joined(flights)
    card = ModelCard(
        inputs=INVERSE_INPUTS,
        outputs=ACCELERATING_OUTPUTS[: outputs.shape[1]],
        preview=preview,
        sample_time_s=sample_time_s,
        vehicle=vehicle,
        data_sha256=hashlib.sha256(inputs.tobytes() + outputs.tobytes()).hexdigest(),
        data_seconds=len(inputs) * sample_time_s,
        data_flights=len(flights),
        seed=seed,
        held_out_rms=tuple(fit.held_out_rms.tolist()),
        lookahead_s=lookahead_s,
        loops=loops,
        software=version("impromptu"),
    )
    return InverseNetwork(card, fit.layers, fit.input_scaling, fit.output_scaling)


def estimated_preview(loops: AxisLoops) -> Preview:
    """The preview that a vehicle's linear model asks for, instead of `PREVIEW`.

    Of the velocity, its dead time and r − 1 steps, as in the paper; of the position what `PREVIEW` has, for a
    longer one does not tell how far the vehicle is beside its path.
    """
    north, east, down = (loop.delay_s + (loop.relative_degree - 1) * loop.step_s for loop in loops)
    return Preview(position_s=PREVIEW.position_s, velocity_s=(north, east, down))


def _common_vehicle(recordings: Sequence[Recording]) -> str:
    vehicles = sorted({recording.provenance.vehicle for recording in recordings})
    if len(vehicles) != 1:
        raise InputError(
            f"flights of {', '.join(vehicles)}: one network is one vehicle's; say --name if they are the same"
        )
    return vehicles[0]


def train(
    training: Samples,
    held_out: Samples,
    *,
    seed: int,
    hidden_layers: Sequence[int] = HIDDEN_LAYERS,
    progress: Progress | None = None,
) -> Fit:
    """Fit a network of rectified linear units to samples; deterministic, on one core.

    The weights of the lowest error on what is held out are kept.

    Raises:
        InputError: torch is missing.
    """
    try:
        from companion.learning.descent import descend
    except ModuleNotFoundError as error:
        raise InputError("training needs torch: install it with `pip install 'impromptu[train]'`") from error
    scalings = input_scaling(training.inputs), output_scaling(training.outputs)
    to_fit, to_check = (_standardised(samples, *scalings) for samples in (training, held_out))
    layers = descend(to_fit, to_check, hidden_layers, seed=seed, progress=progress)
    residual = (propagated(to_check[0], layers) - to_check[1]) * scalings[1].scale
    return Fit(layers, *scalings, np.sqrt(np.mean(residual.astype(np.float64) ** 2, axis=0)))


def _standardised(
    samples: Samples, of_inputs: Scaling, of_outputs: Scaling
) -> tuple[Float[Array32, "n d"], Float[Array32, "n m"]]:
    outputs = ((samples.outputs - of_outputs.mean) / of_outputs.scale).astype(np.float32)
    return normalised(samples.inputs, of_inputs), outputs
