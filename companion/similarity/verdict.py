"""What the figures come to, in words: transfer, transfer with small gain, or train anew."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from enum import StrEnum

import numpy as np

from companion.similarity.comparison import AxisComparison, Figures

NEAR = 0.35
"""ν-gap under which a network serves as it is."""
FAR = 0.85
"""ν-gap from which on there is nothing to carry over."""
UNSURE = 0.6
"""Width of the ν-gap's interval from which on two flights do not tell."""
DRIFTING_M_S = 0.1
"""Speed at which a position that moves beside its velocity misleads any network (m/s)."""


class Verdict(StrEnum):
    """Whether to fly a source's network on a target."""

    TRANSFER = "transfer"
    SMALL_GAIN = "transfer with small gain"
    TRAIN_ANEW = "train anew"

    @property
    def transfers(self) -> bool:
        """Whether the network is to be flown at all."""
        return self is not Verdict.TRAIN_ANEW

    @property
    def advice(self) -> str:
        """What to do."""
        return _ADVICE[self]


_ADVICE = {
    Verdict.TRANSFER: "to do: fly it, as `dnn+gp`, or as `dnn`",
    Verdict.SMALL_GAIN: "to do: fly it as `dnn+gp`, which finds the network's share in flight, not as `dnn`",
    Verdict.TRAIN_ANEW: "to do: `companion collect` on the target, then `companion train`",
}


@dataclass(frozen=True)
class Judgement:
    """A verdict.

    Attributes:
        verdict: of the whole flights.
        confidence: share of the resampled flights that give the same; NaN without resamples.
        reasons: what it rests on, a sentence each.
    """

    verdict: Verdict
    confidence: float
    reasons: tuple[str, ...]


def verdict(axes: Sequence[AxisComparison]) -> Judgement:
    """The verdict on a comparison, by the worst axis.

    Train anew where (A2) fails, so that there is no inverse to carry over, or where the ν-gap is `FAR`;
    transfer where it is under `NEAR` on all axes; with a small gain between, and where the target's estimate
    drifts, which no similarity makes up for.
    """
    found = rule([axis.figures for axis in axes])
    drawn = [rule(each) for each in zip(*(axis.resampled for axis in axes), strict=True)]
    confidence = sum(each is found for each in drawn) / len(drawn) if drawn else float("nan")
    return Judgement(found, confidence, tuple(_reasons(axes)))


def rule(axes: Sequence[Figures]) -> Verdict:
    """The verdict on one set of figures, an axis each."""
    gap = max(each.nu_gap for each in axes)
    if gap >= FAR or not all(each.a2_holds for each in axes):
        return Verdict.TRAIN_ANEW
    drifts = max(each.drift_m_s for each in axes) > DRIFTING_M_S
    return Verdict.SMALL_GAIN if drifts or gap >= NEAR else Verdict.TRANSFER


def _reasons(axes: Sequence[AxisComparison]) -> list[str]:
    reasons = [f"{axis.axis}: {reason}" for axis in axes for reason in _reasons_of(axis)]
    worst = max(axes, key=lambda axis: axis.figures.nu_gap)
    gap = worst.interval(lambda f: f.nu_gap)
    bounds = "" if np.isnan(gap.low) else f" ({gap.low:.2f} to {gap.high:.2f})"
    greatest = f"greatest ν-gap {gap.value:.2f}{bounds}, {worst.axis}"
    return [*reasons, f"{greatest}: near is under {NEAR}, far from {FAR} on"]


def _reasons_of(axis: AxisComparison) -> Iterator[str]:
    f = axis.figures
    for whose, structure in (("source", f.source), ("target", f.target)):
        if not structure.minimum_phase:
            yield f"the {whose} is not minimum phase, its inverse is refused (A2)"
    if not f.same_relative_degree:
        leads = f"the source answers after {f.source.lead_s:.2f} s, the target after {f.target.lead_s:.2f} s"
        yield f"{leads}: not the same relative degree (A2)"
    gap = axis.interval(lambda each: each.nu_gap)
    if gap.high - gap.low > UNSURE:
        yield "these flights tell too little to say: fly longer, and with quicker turns"
    if f.drift_m_s > DRIFTING_M_S:
        drift = f"{f.drift_m_s:.2f} m/s RMS"
        yield f"the target's position moves beside its velocity by {drift}, which misleads any network"
