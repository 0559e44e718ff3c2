"""The comparison of two vehicles for people, as a table and remarks, and for programs."""

from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

from rich.box import SIMPLE_HEAD
from rich.table import Table

from companion.similarity.comparison import AxisComparison, Figures, Interval
from companion.similarity.moments import SPEED_BANDS_M_S
from companion.similarity.structure import Structure
from companion.similarity.verdict import Judgement


class _Row(NamedTuple):
    title: str
    of: Callable[[Figures], float]


_ROWS = {
    "s1": _Row("S1", lambda f: f.s.S1),
    "s2_position": _Row("S2, position", lambda f: float(f.s.S2[0])),
    "s2_velocity": _Row("S2, velocity", lambda f: float(f.s.S2[1])),
    "s2_acceleration": _Row("S2, acceleration", lambda f: float(f.s.S2[2])),
    "s2_norm": _Row("‖S2‖", lambda f: f.s.S2_norm),
    "nu_gap": _Row("ν-gap", lambda f: f.nu_gap),
    "l1": _Row("L1", lambda f: f.lemma.response.L1),
    "l2": _Row("L2", lambda f: f.lemma.response.L2),
    "l1_limit": _Row("(i): L1 under 1/‖𝒜s/ℬs‖", lambda f: f.lemma.aggressiveness_limit),
    "beta_1": _Row("β1", lambda f: f.lemma.prediction.beta_1),
    "beta_2": _Row("β2", lambda f: f.lemma.prediction.beta_2),
    "beta_3": _Row("β3", lambda f: f.lemma.prediction.beta_3),
    "beta_4": _Row("β4", lambda f: f.lemma.beta_4),
    "lemma_1_alpha": _Row("Lemma 1: |α| under", lambda f: f.lemma.largest_gain),
    "lemma_1_state": _Row("Lemma 1: ‖x‖ under, α = 0", lambda f: f.lemma.state_bound(0.0, desired=1.0)),
    "loop_radius": _Row("loop's radius, α = 0", lambda f: f.loop_radius),
    "stable_alpha": _Row("loop stable: α under", lambda f: f.stable_gain),
    "exact_alpha": _Row("α* = 1/ℬt", lambda f: f.exact_gain),
    "inverse_error": _Row("inverse's error", lambda f: f.inverse_error),
}
_FROM_RESAMPLES = ("beta_1", "beta_2", "beta_3")
"""Bounds that stand for the resamples themselves."""


def figures_table(axes: Sequence[AxisComparison]) -> Table:
    """Every figure of every axis, with its interval."""
    table = Table(box=SIMPLE_HEAD, title="source / target; in brackets: 95 % confidence intervals")
    table.add_column("")
    for axis in axes:
        table.add_column(axis.axis, justify="right", no_wrap=True)
    table.add_row("relative degree", *(_both(axis, lambda s: str(s.relative_degree)) for axis in axes))
    table.add_row("dead time (s)", *(_both(axis, lambda s: f"{s.delay_s:.2f}") for axis in axes))
    table.add_row("zeros", *(_both(axis, _zeros) for axis in axes))
    table.add_row("A2 holds", *(_a2(axis) for axis in axes))
    for key, row in _ROWS.items():
        bare = key in _FROM_RESAMPLES
        table.add_row(row.title, *(_text(axis.interval(row.of), bare=bare) for axis in axes))
    for band, speed in enumerate(_band_names()):
        table.add_row(f"θ1, θ2 (m) {speed}", *(_theta(axis, band) for axis in axes))
    return table


def remarks(axes: Sequence[AxisComparison], judgement: Judgement) -> list[str]:
    """What the table means, the verdict last."""
    said = []
    vacuous = [axis.axis for axis in axes if axis.figures.lemma.vacuous]
    if vacuous:
        said.append(
            f"Lemma 1 is vacuous ({', '.join(vacuous)}): its condition fails at α = 0 already. "
            "It is sufficient, not necessary: that it fails says nothing against a transfer."
        )
    said.extend(judgement.reasons)
    return [*said, f"verdict: {judgement.verdict} (in {judgement.confidence:.0%} of the resampled flights)"]


def as_json(axes: Sequence[AxisComparison], judgement: Judgement) -> dict[str, Any]:
    """The same, and everything else, by names."""
    return {
        "verdict": judgement.verdict,
        "confidence": judgement.confidence,
        "reasons": judgement.reasons,
        "axes": {axis.axis: _axis_json(axis) for axis in axes},
    }


def _axis_json(axis: AxisComparison) -> dict[str, Any]:
    f = axis.figures
    return {
        "target_drift_m_s": axis.drift_m_s,
        "source": _structure_json(f.source),
        "target": _structure_json(f.target),
        "a2": {
            "holds": f.a2_holds,
            "same_relative_degree": f.same_relative_degree,
            "share_of_resamples": axis.share(lambda each: each.a2_holds),
        },
        "scenario_i_holds": f.lemma.holds(0.0),
        "lemma_1_vacuous": f.lemma.vacuous,
        "figures": {key: axis.interval(row.of)._asdict() for key, row in _ROWS.items()},
        "envelope": {
            speed: None if measure is None else vars(measure)
            for speed, measure in zip(_band_names(), axis.envelope, strict=True)
        },
    }


def _structure_json(structure: Structure) -> dict[str, Any]:
    return {
        "relative_degree": structure.relative_degree,
        "delay_s": structure.delay_s,
        "lead_s": structure.lead_s,
        "zeros": [[float(zero.real), float(zero.imag)] for zero in structure.zeros],
        "minimum_phase": structure.minimum_phase,
    }


def _band_names() -> list[str]:
    first, second = SPEED_BANDS_M_S
    return [f"to {first} m/s", f"to {second} m/s", "faster"]


def _both(axis: AxisComparison, of: Callable[[Structure], str]) -> str:
    return f"{of(axis.figures.source)} / {of(axis.figures.target)}"


def _zeros(structure: Structure) -> str:
    return ", ".join(f"{zero if zero.imag else zero.real:.2f}" for zero in structure.zeros) or "none"


def _a2(axis: AxisComparison) -> str:
    answer = "yes" if axis.figures.a2_holds else "no"
    return f"{answer} [{axis.share(lambda f: f.a2_holds):.0%}]"


def _theta(axis: AxisComparison, band: int) -> str:
    measure = axis.envelope[band]
    return "too little flown" if measure is None else f"{measure.theta_1:.2f}, {measure.theta_2_m:.3f}"


def _text(interval: Interval, *, bare: bool) -> str:
    if bare:
        return f"{interval.value:.2g}"
    return f"{interval.value:.2g}\n[{interval.low:.2g}, {interval.high:.2g}]"
