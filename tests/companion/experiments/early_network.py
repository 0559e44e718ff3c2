"""A stand-in for a trained network: one linear layer that asks for what is desired one preview ahead."""

import numpy as np

from companion.learning.features import INVERSE_INPUTS, INVERSE_OUTPUTS, Preview
from companion.learning.inverse_network import InverseNetwork, Layer, ModelCard, Scaling


def early_network(lead_s: float = 0.2, vehicle: str = "ardrone2") -> InverseNetwork:
    card = ModelCard(
        inputs=INVERSE_INPUTS,
        outputs=INVERSE_OUTPUTS,
        preview=Preview.of_time(lead_s),
        sample_time_s=0.02,
        vehicle=vehicle,
        data_sha256="0" * 64,
        data_seconds=400.0,
        seed=0,
        held_out_rms=(0.01,) * 6,
        lookahead_s=lead_s,
        software="0.1.0",
    )
    return InverseNetwork(
        card, (Layer(np.eye(12, 6, dtype=np.float32), _zeros(6)),), _unscaled(12), _unscaled(6)
    )


def _zeros(width: int) -> np.ndarray[tuple[int, ...], np.dtype[np.float32]]:
    return np.zeros(width, dtype=np.float32)


def _unscaled(width: int) -> Scaling:
    return Scaling(_zeros(width), _zeros(width) + np.float32(1.0))
