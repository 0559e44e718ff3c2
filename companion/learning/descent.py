"""Gradient descent on the weights of a network, with torch: the one module that imports it."""

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from itertools import pairwise

import numpy as np
import torch
from jaxtyping import Float
from torch import nn

from companion.learning.inverse_network import Array32, Layer

BATCH = 256
MOST_EPOCHS = 200
LEARNING_RATE = 1e-3
PATIENCE = 8
"""Epochs without a better held-out error after which the learning rate is halved."""
SMALLEST_RATE = 3e-5
"""Learning rate below which training stops."""


def descend(
    training: tuple[Float[Array32, "n d"], Float[Array32, "n m"]],
    held_out: tuple[Float[Array32, "k d"], Float[Array32, "k m"]],
    hidden_layers: Sequence[int],
    *,
    seed: int,
    progress: Callable[[int, float], None] | None = None,
) -> tuple[Layer, ...]:
    """Layers of the network that fits standardised samples best in the mean square, by Adam.

    The learning rate falls when the held-out error no longer does, and training stops when the rate is small;
    the weights of the lowest held-out error are kept. Deterministic: same samples and seed, same bits.
    """
    x, y = (torch.from_numpy(part) for part in training)
    held_out_x, held_out_y = (torch.from_numpy(part) for part in held_out)
    with _reproducible(seed):
        network = _network((x.shape[1], *hidden_layers, y.shape[1]))
        optimiser = torch.optim.Adam(network.parameters(), lr=LEARNING_RATE)
        schedule = torch.optim.lr_scheduler.ReduceLROnPlateau(
            optimiser, factor=0.5, patience=PATIENCE, threshold=1e-3
        )
        best, layers = np.inf, _layers(network)
        for epoch in range(1, MOST_EPOCHS + 1):
            for batch in torch.split(torch.randperm(len(x)), BATCH):
                optimiser.zero_grad()
                nn.functional.mse_loss(network(x[batch]), y[batch]).backward()  # type: ignore[no-untyped-call]
                optimiser.step()
            with torch.no_grad():
                error = float(nn.functional.mse_loss(network(held_out_x), held_out_y))
            if error < best:
                best, layers = error, _layers(network)
            if progress is not None:
                progress(epoch, error**0.5)
            schedule.step(error)
            if schedule.get_last_lr()[0] < SMALLEST_RATE:
                break
    return layers


@contextmanager
def _reproducible(seed: int) -> Iterator[None]:
    """Torch's generator seeded, and one thread: sums in one order. Both are put back afterwards."""
    threads = torch.get_num_threads()
    torch.set_num_threads(1)
    try:
        with torch.random.fork_rng(devices=[]):
            torch.manual_seed(seed)
            yield
    finally:
        torch.set_num_threads(threads)


def _network(widths: Sequence[int]) -> nn.Sequential:
    modules: list[nn.Module] = []
    for inputs, outputs in pairwise(widths):
        modules += [nn.Linear(inputs, outputs), nn.ReLU()]
    return nn.Sequential(*modules[:-1])


def _layers(network: nn.Sequential) -> tuple[Layer, ...]:
    return tuple(
        Layer(module.weight.detach().numpy().T.copy(), module.bias.detach().numpy().copy())
        for module in network
        if isinstance(module, nn.Linear)
    )
