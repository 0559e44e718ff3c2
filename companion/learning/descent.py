"""Gradient descent on the weights of a network, with torch: the one module that imports it."""

import math
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from itertools import pairwise

import torch
from jaxtyping import Float
from torch import nn
from torch.optim.swa_utils import AveragedModel

from companion.learning.inverse_network import Array32, Layer

BATCH = 256
LEARNING_RATE = 1e-3
WEIGHT_DECAY = 1.0
"""Of AdamW. Neighbouring samples of a smooth flight are alike and its inputs nearly collinear.

A network that is free to leans on their small differences, and in the loop that throws the vehicle.
"""
MEMORY = 500
"""Steps over whose weights the mean is taken: weights that fit equally well may fly differently."""
CHECK_EVERY = 100
"""Steps between two looks at the held-out error."""
PATIENCE = 15
"""Looks without a lower held-out error after which training stops."""
LEAST_GAIN = 0.005
"""Share by which the held-out mean square has to fall to count as lower."""
MOST_STEPS = 20_000


def descend(
    training: tuple[Float[Array32, "n d"], Float[Array32, "n m"]],
    held_out: tuple[Float[Array32, "k d"], Float[Array32, "k m"]],
    hidden_layers: Sequence[int],
    *,
    seed: int,
    progress: Callable[[int, float], None] | None = None,
) -> tuple[Layer, ...]:
    """Layers of the network that fits standardised samples in the mean square, and stays calm in the loop.

    Adam with decoupled weight decay (Loshchilov and Hutter 2019) on random batches; the network is the moving
    mean of the weights (Polyak and Juditsky 1992), taken where its held-out error was lowest, and training
    stops when that no longer falls. Same samples and seed, same bits.
    """
    x, y = (torch.from_numpy(part) for part in training)
    held_out_x, held_out_y = (torch.from_numpy(part) for part in held_out)
    with _reproducible(seed):
        network = _network((x.shape[1], *hidden_layers, y.shape[1]))
        averaged = AveragedModel(network, avg_fn=_moving_mean)
        optimiser = torch.optim.AdamW(network.parameters(), lr=LEARNING_RATE, weight_decay=WEIGHT_DECAY)
        best, best_step, layers = math.inf, 0, _layers(network)
        for step in range(1, MOST_STEPS + 1):
            batch = torch.randint(len(x), (BATCH,))
            optimiser.zero_grad()
            nn.functional.mse_loss(network(x[batch]), y[batch]).backward()  # type: ignore[no-untyped-call]
            optimiser.step()
            averaged.update_parameters(network)
            if step % CHECK_EVERY:
                continue
            with torch.no_grad():
                error = float(nn.functional.mse_loss(averaged(held_out_x), held_out_y))
            if progress is not None:
                progress(step, math.sqrt(error))
            if error < (1.0 - LEAST_GAIN) * best:
                best, best_step, layers = error, step, _layers(averaged.module)
            elif step - best_step >= PATIENCE * CHECK_EVERY:
                break
    return layers


def _moving_mean(mean: torch.Tensor, newest: torch.Tensor, steps: torch.Tensor | int) -> torch.Tensor:
    """The mean over about the newest tenth of all steps, and at most over `MEMORY` of them."""
    return mean + (newest - mean) / min(1.0 + int(steps) / 10.0, MEMORY)


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


def _layers(network: nn.Module) -> tuple[Layer, ...]:
    return tuple(
        Layer(module.weight.detach().numpy().T.copy(), module.bias.detach().numpy().copy())
        for module in network.modules()
        if isinstance(module, nn.Linear)
    )
