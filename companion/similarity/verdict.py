"""What the figures come to, in words: transfer, transfer with small gain, or train anew."""

from collections.abc import Sequence
from dataclasses import dataclass
from enum import StrEnum

from companion.similarity.comparison import AxisComparison, Figures

NEAR = 0.35
"""ν-gap under which a network serves as it is."""
FAR = 0.65
"""ν-gap from which on it does harm."""


class Verdict(StrEnum):
    """Whether to fly a source's network on a target."""

    TRANSFER = "transfer"
    SMALL_GAIN = "transfer with small gain"
    TRAIN_ANEW = "train anew"

    @property
    def transfers(self) -> bool:
        """Whether the network is to be flown at all."""
        return self is not Verdict.TRAIN_ANEW


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
    transfer where it is under `NEAR` on all axes; with a small gain between.
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
    return Verdict.TRANSFER if gap < NEAR else Verdict.SMALL_GAIN


def _reasons(axes: Sequence[AxisComparison]) -> list[str]:
    reasons = []
    for axis in axes:
        f = axis.figures
        for whose, structure in (("source", f.source), ("target", f.target)):
            if not structure.minimum_phase:
                reasons.append(f"{axis.axis}: the {whose} is not minimum phase, its inverse is refused (A2)")
        if not f.same_relative_degree:
            reasons.append(
                f"{axis.axis}: the source answers after {f.source.lead_s:.2f} s, the target after "
                f"{f.target.lead_s:.2f} s (A2)"
            )
    worst = max(axes, key=lambda axis: axis.figures.nu_gap)
    gap = worst.interval(lambda f: f.nu_gap)
    reasons.append(
        f"greatest ν-gap {gap.value:.2f} ({gap.low:.2f} to {gap.high:.2f}), {worst.axis}: "
        f"near is under {NEAR}, far from {FAR} on"
    )
    return reasons
