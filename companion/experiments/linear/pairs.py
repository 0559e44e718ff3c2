"""The linear experiment over random pairs: does it diverge, what does it gain, what does Lemma 1 say?"""

from collections.abc import Iterable, Iterator, Sequence
from functools import partial

import numpy as np
from jaxtyping import Bool, Float
from pydantic import BaseModel, ConfigDict

from companion.arrays import Array
from companion.experiments.backend import LOCAL
from companion.experiments.linear.experiment import Track, desired_outputs, rms, track
from companion.experiments.linear.guarded import GuardedCorrection
from companion.experiments.linear.inverse import ExactInverse
from companion.experiments.linear.online import OnlineSettings
from companion.experiments.linear.random_pairs import draw_pair
from companion.similarity.lemma import lemma_1, state_response
from companion.similarity.transfer_loop import largest_stable_gain

DURATION_S = 16.0
"""One period of the paper's trajectory."""

DIVERGED = 100.0
"""A run has diverged if its output exceeds this many times the largest of desired and baseline output."""

HALF = 0.5
"""Of the reference: the guard has fallen back where less than this is learned."""


class PairRow(BaseModel):
    """One pair.

    Attributes:
        index: number of the pair in the series of the seed.
        order, relative_degree, sample_time_s: of both systems.
        baseline_rms: tracking error of the plain reference.
        network_rms: of the source's inverse alone; None where that diverges.
        dnn_gp_rms: of the inverse with the online correction under the guard.
        ratio: that over the baseline's.
        diverged: whether the output of dnn_gp left all bounds.
        fell_back: whether the guard took the learned reference back, after it had trusted it or for good.
        fallback_share: share of the steps in which the plain reference was flown for that.
        alpha: the online gain, median over the second half of the run.
        lemma_alpha_bound: largest alpha for which Lemma 1 holds; 0 where it fails at alpha = 0 already.
        lemma_held: whether it held at `alpha`.
        largest_stable_alpha: up to which gain the loop is stable, from 0 on; 0 where it is not stable there.
    """

    model_config = ConfigDict(frozen=True)

    index: int
    order: int
    relative_degree: int
    sample_time_s: float
    baseline_rms: float
    network_rms: float | None
    dnn_gp_rms: float
    ratio: float
    diverged: bool
    fell_back: bool
    fallback_share: float
    alpha: float
    lemma_alpha_bound: float
    lemma_held: bool
    largest_stable_alpha: float


class PairsSummary(BaseModel):
    """What the pairs say together.

    Attributes:
        pairs: how many.
        diverged: how many diverged under the guarded correction.
        median_ratio, worst_ratio: of RMS error over the baseline's.
        worse_than_baseline: how many pairs have a ratio above 1.
        network_diverged_share: share of pairs on which the source's inverse alone diverges.
        fell_back_share, fallback_steps_share: share of pairs, and of all steps, in which the guard fell back.
        lemma_held_share: share of pairs for which Lemma 1 held at the gain that was used.
        lemma_bounds_share: share of pairs for which it holds at any gain at all.
        lemma_conservatism_median: over these pairs, its bound on alpha over the largest stable alpha.
    """

    pairs: int
    diverged: int
    median_ratio: float
    worst_ratio: float
    worse_than_baseline: int
    network_diverged_share: float
    fell_back_share: float
    fallback_steps_share: float
    lemma_held_share: float
    lemma_bounds_share: float
    lemma_conservatism_median: float | None


def fly_pairs(indices: Sequence[int], *, seed: int, noise: float) -> Iterator[PairRow]:
    """Rows of the pairs with these numbers, on all cores, in their order."""
    return LOCAL.each(partial(fly_pair, seed=seed, noise=noise), indices)


def fly_pair(index: int, *, seed: int, noise: float) -> PairRow:
    """Fly one pair with the plain reference, with the source's inverse, and with the guarded correction.

    The exact inverse of the source stands for a network, as the paper's analysis has it (A4).

    Args:
        index: number of the pair in the series of the seed.
        seed: of the series, the noise and the probe.
        noise: standard deviation of all measurements, over the range of the desired output.
    """
    pair = draw_pair(seed, index)
    source, target = pair.source, pair.target
    r = target.relative_degree
    steps = round(DURATION_S / pair.sample_time_s)
    desired = desired_outputs(steps + r, sample_time_s=pair.sample_time_s)
    fly = partial(track, target, desired, noise=noise * float(np.ptp(desired)), seed=seed)
    inverse = ExactInverse(source)
    guarded = GuardedCorrection(inverse, r, OnlineSettings(), seed=seed)
    baseline = fly(lambda _state, _output, y_d: y_d)
    with np.errstate(over="ignore", invalid="ignore"):
        network = fly(lambda state, _output, y_d: inverse(state, y_d))
        dnn_gp = fly(guarded)

    desired = desired[:steps]
    bound = DIVERGED * float(np.max(np.abs([desired, baseline.outputs])))
    baseline_rms, dnn_gp_rms = rms(baseline.outputs - desired), rms(dnn_gp.outputs - desired)
    fallen_back = _fallen_back(np.array(guarded.weights))
    alpha = float(np.median([correction.alpha for correction in guarded.corrections[steps // 2 :]]))
    lemma = lemma_1(source.gains, target.gains, state_response(target))
    return PairRow(
        index=index,
        order=len(target.B),
        relative_degree=r,
        sample_time_s=pair.sample_time_s,
        baseline_rms=baseline_rms,
        network_rms=None if _diverged(network, bound) else rms(network.outputs - desired),
        dnn_gp_rms=dnn_gp_rms,
        ratio=dnn_gp_rms / baseline_rms,
        diverged=_diverged(dnn_gp, bound),
        fell_back=bool(fallen_back.any()),
        fallback_share=float(fallen_back.mean()),
        alpha=alpha,
        lemma_alpha_bound=lemma.largest_gain,
        lemma_held=lemma.holds(alpha),
        largest_stable_alpha=largest_stable_gain(source.gains, target, target.gains),
    )


def summarise(rows: Sequence[PairRow]) -> PairsSummary:
    """The figures over all rows, of which there is at least one."""
    ratios = [row.ratio for row in rows]
    conservatism = [
        row.lemma_alpha_bound / row.largest_stable_alpha for row in rows if row.lemma_alpha_bound > 0.0
    ]
    return PairsSummary(
        pairs=len(rows),
        diverged=sum(row.diverged for row in rows),
        median_ratio=float(np.median(ratios)),
        worst_ratio=max(ratios),
        worse_than_baseline=sum(ratio > 1.0 for ratio in ratios),
        network_diverged_share=_share(row.network_rms is None for row in rows),
        fell_back_share=_share(row.fell_back for row in rows),
        fallback_steps_share=float(np.mean([row.fallback_share for row in rows])),
        lemma_held_share=_share(row.lemma_held for row in rows),
        lemma_bounds_share=_share(row.lemma_alpha_bound > 0.0 for row in rows),
        lemma_conservatism_median=float(np.median(conservatism)) if conservatism else None,
    )


def _diverged(run: Track, bound: float) -> bool:
    return not np.max(np.abs(run.outputs)) <= bound  # NaN compares as false


def _fallen_back(weights: Float[Array, " k"]) -> Bool[Array, " k"]:
    """The steps in which little learned is used, those aside in which the guard has yet to trust it."""
    trusted = np.maximum.accumulate(weights >= HALF)
    fallen_back: Bool[Array, " k"] = (weights < HALF) & (trusted | ~trusted[-1])
    return fallen_back


def _share(each: Iterable[bool]) -> float:
    return float(np.mean(list(each)))
