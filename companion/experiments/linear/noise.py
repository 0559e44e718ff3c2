"""The paper's simulation with noisy measurements: is the correction ever worse than the network alone?"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from itertools import product

import numpy as np

from companion.experiments.backend import LOCAL
from companion.experiments.linear.experiment import STEPS, desired_outputs, evaluate
from companion.experiments.linear.inverse import InverseNetwork
from companion.experiments.linear.online import OnlineSettings
from companion.experiments.linear.system import LinearSystem

NOISE_LEVELS = (1e-4, 1e-3, 1e-2)
"""Standard deviation of the noise on states and output, over the range of the desired output."""


@dataclass(frozen=True)
class NoiseFigures:
    """One level of noise, over several draws.

    Attributes:
        noise: the level, as in `NOISE_LEVELS`.
        baseline_rms, dnn_rms, dnn_gp_rms: tracking error of the true output, medians over the draws.
        worst_ratio: largest error with the online correction over that of the network alone, same draw.
        draws: how many.
        not_worse: draws in which that ratio is at most 1.
    """

    noise: float
    baseline_rms: float
    dnn_rms: float
    dnn_gp_rms: float
    worst_ratio: float
    draws: int
    not_worse: int


def noise_figures(
    target: LinearSystem,
    network: InverseNetwork,
    settings: OnlineSettings,
    *,
    seeds: Sequence[int],
    levels: Sequence[float] = NOISE_LEVELS,
    steps: int = STEPS,
) -> Iterator[NoiseFigures]:
    """Fly the trajectory at each level and with each seed, on all cores; figures for each level."""
    if not seeds:
        return
    fly = partial(_fly, target, network, settings, steps)
    flown = LOCAL.each(fly, list(product(levels, seeds)))
    for level in levels:
        errors = np.array([next(flown) for _ in seeds])
        ratios = errors[:, 2] / errors[:, 1]
        baseline, dnn, dnn_gp = np.median(errors, axis=0).tolist()
        yield NoiseFigures(
            noise=level,
            baseline_rms=baseline,
            dnn_rms=dnn,
            dnn_gp_rms=dnn_gp,
            worst_ratio=float(ratios.max()),
            draws=len(seeds),
            not_worse=int(np.sum(ratios <= 1.0)),
        )


def _fly(
    target: LinearSystem,
    network: InverseNetwork,
    settings: OnlineSettings,
    steps: int,
    level_and_seed: tuple[float, int],
) -> tuple[float, float, float]:
    level, seed = level_and_seed
    noise = level * float(np.ptp(desired_outputs(STEPS)))
    figures = evaluate(target, network, settings, steps=steps, noise=noise, seed=seed).figures()
    return figures.baseline_rms, figures.dnn_rms, figures.dnn_gp_rms
