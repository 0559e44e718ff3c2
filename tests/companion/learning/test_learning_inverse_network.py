from contextlib import suppress
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
import torch
from hypothesis import given, settings
from hypothesis import strategies as st

from companion.arrays import Array
from companion.errors import InputError
from companion.learning.features import ACCELERATING_OUTPUTS, INVERSE_INPUTS, INVERSE_OUTPUTS, Preview
from companion.learning.inverse_network import (
    FARTHEST_INPUT,
    LEAST_SPREAD,
    InverseNetwork,
    Layer,
    ModelCard,
    Scaling,
    input_scaling,
    normalised,
    output_scaling,
)
from companion.learning.model_file import LARGEST_FILE, load_model, save_model

CARD = ModelCard(
    inputs=INVERSE_INPUTS,
    outputs=INVERSE_OUTPUTS,
    preview=Preview.of_time(0.36),
    sample_time_s=0.02,
    vehicle="spring",
    data_sha256="0" * 64,
    data_seconds=400.0,
    seed=0,
    held_out_rms=(0.01,) * 6,
    lookahead_s=0.3,
    software="0.1.0",
)


ACCELERATING_CARD = CARD.model_copy(
    update={"outputs": ACCELERATING_OUTPUTS, "held_out_rms": (0.01,) * len(ACCELERATING_OUTPUTS)}
)


def random_network(
    seed: int = 0, widths: tuple[int, ...] = (12, 128, 128, 128, 128, 6), card: ModelCard = CARD
) -> InverseNetwork:
    rng = np.random.default_rng(seed)
    layers = tuple(
        Layer(
            rng.normal(scale=inputs**-0.5, size=(inputs, outputs)).astype(np.float32),
            rng.normal(size=outputs).astype(np.float32),
        )
        for inputs, outputs in pairwise(widths)
    )
    samples = rng.normal(size=(100, 12))
    samples[:, 8] = 0.0  # the yaw
    return InverseNetwork(
        card, layers, input_scaling(samples), output_scaling(rng.normal(size=(100, widths[-1])))
    )


def with_torch(network: InverseNetwork, inputs: Array) -> Array:
    x = torch.from_numpy(normalised(inputs, network.input_scaling))
    for weight, bias in network.layers[:-1]:
        x = torch.relu(x @ torch.from_numpy(weight) + torch.from_numpy(bias))
    x = x @ torch.from_numpy(network.layers[-1].weight) + torch.from_numpy(network.layers[-1].bias)
    return np.asarray(
        x.numpy() * network.output_scaling.scale + network.output_scaling.mean, dtype=np.float64
    )


def test_inference_equals_torch() -> None:
    network, inputs = random_network(), np.random.default_rng(1).normal(size=(50, 12))
    np.testing.assert_allclose(network(inputs), with_torch(network, inputs), atol=1e-5)
    for row in inputs:
        np.testing.assert_allclose(network(row), with_torch(network, row), atol=1e-5)
        assert network(row).shape == (6,)
        assert network(row).dtype == np.float64


@given(st.floats(-1e6, 1e6))
def test_an_input_that_hardly_varied_in_training_does_not_matter(yaw: float) -> None:
    network, inputs = random_network(), np.full(12, 0.3)
    turned = inputs.copy()
    turned[8] = yaw
    np.testing.assert_array_equal(network(turned), network(inputs))


def test_which_inputs_are_dropped() -> None:
    rng = np.random.default_rng(0)
    samples = np.column_stack(
        (rng.normal(scale=0.5 * LEAST_SPREAD, size=500), rng.normal(scale=2.0 * LEAST_SPREAD, size=500))
    )
    scale = input_scaling(samples).scale
    assert np.isinf(scale[0])
    assert scale[1] == pytest.approx(2.0 * LEAST_SPREAD, rel=0.1)
    np.testing.assert_array_equal(output_scaling(samples).scale, [1.0, scale[1]])


@given(st.floats(-1e30, 1e30))
def test_far_inputs_are_clipped(value: float) -> None:
    seen = normalised(np.full(3, value), Scaling(np.zeros(3, np.float32), np.ones(3, np.float32)))
    assert (np.abs(seen) <= FARTHEST_INPUT).all()


def test_nan_in_nan_out() -> None:
    inputs = np.zeros(12)
    inputs[2] = np.nan
    assert np.isnan(random_network()(inputs)).all()


@pytest.mark.parametrize("card", [CARD, ACCELERATING_CARD])
def test_a_model_file_returns_every_bit(tmp_path: Path, card: ModelCard) -> None:
    network = random_network(widths=(12, 16, len(card.outputs)), card=card)
    save_model(network, tmp_path / "a.safetensors")
    loaded = load_model(tmp_path / "a.safetensors")
    save_model(loaded, tmp_path / "b.safetensors")
    assert (tmp_path / "a.safetensors").read_bytes() == (tmp_path / "b.safetensors").read_bytes()
    assert loaded.card == network.card
    inputs = np.random.default_rng(2).normal(size=12)
    np.testing.assert_array_equal(loaded(inputs), network(inputs))


@pytest.fixture(scope="module")
def model_bytes(tmp_path_factory: pytest.TempPathFactory) -> bytes:
    path = tmp_path_factory.mktemp("model") / "small.safetensors"
    save_model(random_network(widths=(12, 4, 6)), path)
    return path.read_bytes()


@settings(max_examples=300, deadline=None)
@given(data=st.data())
def test_a_damaged_model_file_is_an_input_error(
    data: st.DataObject, model_bytes: bytes, tmp_path_factory: pytest.TempPathFactory
) -> None:
    damaged = bytearray(model_bytes)
    for _ in range(data.draw(st.integers(1, 4))):
        damaged[data.draw(st.integers(0, len(damaged) - 1))] = data.draw(st.integers(0, 255))
    kept = data.draw(st.integers(0, len(damaged)) | st.just(len(damaged)))
    path = tmp_path_factory.getbasetemp() / "damaged.safetensors"
    path.write_bytes(damaged[:kept])
    with suppress(InputError):  # damage to a weight's digits cannot be seen, and yields another network
        assert load_model(path)(np.zeros(12)).shape == (6,)


def test_no_such_file(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"nowhere\.safetensors: cannot read the model"):
        load_model(tmp_path / "nowhere.safetensors")
    with pytest.raises(InputError, match="cannot write"):
        save_model(random_network(), tmp_path / "no" / "such" / "folder")
    with pytest.raises(InputError):
        load_model(tmp_path)


def test_a_file_that_is_too_large_is_not_read(tmp_path: Path) -> None:
    path = tmp_path / "large.safetensors"
    with path.open("wb") as file:
        file.truncate(LARGEST_FILE + 1)
    with pytest.raises(InputError, match="too many for a model file"):
        load_model(path)


def test_other_features(tmp_path: Path) -> None:
    network = random_network()
    for names in (
        {"inputs": ("altitude", *INVERSE_INPUTS[1:])},
        {"outputs": ("thrust", *INVERSE_OUTPUTS[1:])},
    ):
        card = CARD.model_copy(update=names)
        other = InverseNetwork(card, network.layers, network.input_scaling, network.output_scaling)
        save_model(other, tmp_path / "other")
        with pytest.raises(InputError, match="other features"):
            load_model(tmp_path / "other")


def test_weights_that_do_not_fit(tmp_path: Path) -> None:
    network = random_network(widths=(12, 4, 6))
    first, last = network.layers
    faulty = {
        "maps 12 numbers to 4": (first,),
        "maps 12 numbers to 9": random_network(widths=(12, 4, 9)).layers,
        "do not fit together": (first, Layer(np.ones((5, 6), np.float32), last.bias)),
        "bias does not fit": (first, Layer(last.weight, first.bias)),
        "not finite": (first, Layer(last.weight * np.float32(np.nan), last.bias)),
        "not a matrix": (Layer(first.bias, first.bias), last),
    }
    for complaint, layers in faulty.items():
        other = InverseNetwork(CARD, layers, network.input_scaling, network.output_scaling)
        save_model(other, tmp_path / "other")
        with pytest.raises(InputError, match=complaint):
            load_model(tmp_path / "other")


def test_a_scale_that_is_not_positive(tmp_path: Path) -> None:
    network = random_network(widths=(12, 4, 6))
    scaling = Scaling(network.input_scaling.mean, np.zeros(12, np.float32))
    save_model(InverseNetwork(CARD, network.layers, scaling, network.output_scaling), tmp_path / "other")
    with pytest.raises(InputError, match="scale is not positive"):
        load_model(tmp_path / "other")
