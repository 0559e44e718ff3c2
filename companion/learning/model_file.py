"""The model file: an inverse network and its card in one safetensors file, without code in it.

Tensors (float32) `input.mean`, `input.scale`, `output.mean`, `output.scale`, `layer.N.weight` (inputs ×
outputs) and `layer.N.bias`; the card as JSON under `card` in the header's metadata.
Format: https://huggingface.co/docs/safetensors
"""

from itertools import pairwise
from pathlib import Path

import numpy as np
from pydantic import ValidationError
from safetensors import SafetensorError, safe_open
from safetensors.numpy import save

from companion.errors import InputError
from companion.learning.features import ACCELERATING_OUTPUTS, INVERSE_INPUTS, INVERSE_OUTPUTS
from companion.learning.inverse_network import Array32, InverseNetwork, Layer, ModelCard, Scaling

LARGEST_FILE = 64 * 2**20
"""Bytes; the paper's network takes 210 KB."""


def save_model(network: InverseNetwork, path: Path) -> None:
    """Write the network to `path`; the same network, the same bytes. InputError if it cannot be written."""
    tensors = {
        "input.mean": network.input_scaling.mean,
        "input.scale": network.input_scaling.scale,
        "output.mean": network.output_scaling.mean,
        "output.scale": network.output_scaling.scale,
    }
    for number, layer in enumerate(network.layers):
        tensors[f"layer.{number}.weight"] = np.ascontiguousarray(layer.weight)
        tensors[f"layer.{number}.bias"] = layer.bias
    try:
        path.write_bytes(save(tensors, metadata={"card": network.card.model_dump_json()}))
    except OSError as error:
        raise InputError(f"{path}: cannot write the model: {error.strerror}") from error


def load_model(path: Path) -> InverseNetwork:
    """Read a network from `path`.

    Raises:
        InputError: no such file, too large, not a model file, damaged, or trained for other features.
    """
    card, tensors = _read(path)
    if card.inputs != INVERSE_INPUTS or card.outputs not in (INVERSE_OUTPUTS, ACCELERATING_OUTPUTS):
        raise InputError(
            f"{path}: the model was trained for other features ({', '.join(card.inputs)} → "
            f"{', '.join(card.outputs)}); train it anew with `companion train`"
        )
    layers = tuple(
        Layer(tensors[f"layer.{number}.weight"], tensors[f"layer.{number}.bias"])
        for number in range((len(tensors) - 4) // 2)
    )
    network = InverseNetwork(
        card=card,
        layers=layers,
        input_scaling=Scaling(tensors["input.mean"], tensors["input.scale"]),
        output_scaling=Scaling(tensors["output.mean"], tensors["output.scale"]),
    )
    fault = _fault(network)
    if fault is not None:
        raise InputError(f"{path}: damaged model file: {fault}; copy it again, or train it anew")
    return network


def _read(path: Path) -> tuple[ModelCard, dict[str, Array32]]:
    try:
        size = path.stat().st_size
        if size > LARGEST_FILE:
            raise InputError(f"{path}: {size} bytes are too many for a model file (at most {LARGEST_FILE})")
        with safe_open(path, framework="numpy") as file:
            text = (file.metadata() or {}).get("card")
            if text is None:
                raise InputError(
                    f"{path}: not an Impromptu model: no card in its header; see `companion train`"
                )
            card = ModelCard.model_validate_json(text)
            names = sorted(file.keys())
            if names != _expected_names(len(names)):
                raise InputError(f"{path}: damaged model file: unexpected tensors; train it anew")
            if any(file.get_slice(name).get_dtype() != "F32" for name in names):
                raise InputError(f"{path}: damaged model file: its tensors are not float32; train it anew")
            return card, {name: file.get_tensor(name) for name in names}
    except OSError as error:
        raise InputError(f"{path}: cannot read the model: {error.strerror or error}") from error
    except SafetensorError as error:
        raise InputError(f"{path}: not a model file, or damaged ({error}); see `companion train`") from error
    except ValidationError as error:
        first = error.errors()[0]
        key = ".".join(str(part) for part in first["loc"])
        raise InputError(
            f"{path}: the model's card is wrong at `{key}`: {first['msg']}; train it anew with this version"
        ) from error


def _expected_names(count: int) -> list[str]:
    layers = range((count - 4) // 2)
    scalings = ["input.mean", "input.scale", "output.mean", "output.scale"]
    return sorted(scalings + [f"layer.{number}.{part}" for number in layers for part in ("weight", "bias")])


def _fault(network: InverseNetwork) -> str | None:
    """What is wrong with the numbers of a network whose card is right."""
    layers = network.layers
    if not layers or any(layer.weight.ndim != 2 or layer.weight.size == 0 for layer in layers):
        return "a layer's weight is not a matrix"
    inputs, outputs = layers[0].weight.shape[0], layers[-1].weight.shape[1]
    if (inputs, outputs) != (len(network.card.inputs), len(network.card.outputs)):
        return f"the network maps {inputs} numbers to {outputs}"
    if any(before.weight.shape[1] != after.weight.shape[0] for before, after in pairwise(layers)):
        return "its layers do not fit together"
    if any(layer.bias.shape != layer.weight.shape[1:] for layer in layers):
        return "a layer's bias does not fit its weight"
    scalings = ((network.input_scaling, inputs), (network.output_scaling, outputs))
    if any(part.shape != (width,) for scaling, width in scalings for part in scaling):
        return "its normalisation does not fit its layers"
    finite = [part for layer in layers for part in layer]
    finite += [network.input_scaling.mean, *network.output_scaling]
    if not all(np.isfinite(part).all() for part in finite):
        return "a weight is not finite"
    if not all((scaling.scale > 0).all() for scaling, _ in scalings):
        return "a scale is not positive"
    return None
