"""The comparison of two vehicles for people, as a table and remarks, and for programs."""

from collections.abc import Callable, Iterable, Sequence
from typing import Any, NamedTuple

import numpy as np
from rich.box import SIMPLE_HEAD
from rich.table import Table
from rich.text import Text

from companion.similarity.comparison import AxisComparison, Figures, Interval
from companion.similarity.identification import AXES
from companion.similarity.moments import SPEED_BANDS_M_S
from companion.similarity.structure import Structure
from companion.similarity.track_record import TrackRecord
from companion.similarity.transfer_loop import MOST_GAIN
from companion.similarity.verdict import Judgement

_BANDS = (*(f"to {speed} m/s" for speed in SPEED_BANDS_M_S), "faster")
_LEAST_DECIMAL = 4
"""Decimals after which the table leaves off."""
_MOST_DIGITS = 1e5
"""From here on, the table shows powers of ten, 1.23e5."""


class _Row(NamedTuple):
    """A figure of each axis.

    Attributes:
        title: short enough for a terminal of 80 columns.
        of: the figure.
        is_bound: it stands for the resamples itself, so that it has no interval.
        most: where the search for it ends.
    """

    title: str
    of: Callable[[Figures], float]
    is_bound: bool = False
    most: float = np.inf


_ROWS = {
    "source_relative_degree": _Row("source: degree", lambda f: f.source.relative_degree),
    "target_relative_degree": _Row("target: degree", lambda f: f.target.relative_degree),
    "source_delay_s": _Row("source: delay (s)", lambda f: f.source.delay_s),
    "target_delay_s": _Row("target: delay (s)", lambda f: f.target.delay_s),
    "target_drift_m_s": _Row("target: drift m/s", lambda f: f.drift_m_s),
    "s1": _Row("S1", lambda f: f.s.S1),
    "s2_position": _Row("S2, position", lambda f: float(f.s.S2[0])),
    "s2_velocity": _Row("S2, velocity", lambda f: float(f.s.S2[1])),
    "s2_acceleration": _Row("S2, acceleration", lambda f: float(f.s.S2[2])),
    "s2_norm": _Row("‖S2‖", lambda f: f.s.S2_norm),
    "nu_gap": _Row("ν-gap", lambda f: f.nu_gap),
    "l1": _Row("L1", lambda f: f.lemma.response.L1),
    "l2": _Row("L2", lambda f: f.lemma.response.L2),
    "inverse_state_gain": _Row("‖𝒜s/ℬs‖", lambda f: f.lemma.inverse_state_gain),
    "l1_limit": _Row("(i): L1 under", lambda f: f.lemma.aggressiveness_limit),
    "beta_1": _Row("β1", lambda f: f.lemma.prediction.beta_1, is_bound=True),
    "beta_2": _Row("β2", lambda f: f.lemma.prediction.beta_2, is_bound=True),
    "beta_3": _Row("β3", lambda f: f.lemma.prediction.beta_3, is_bound=True),
    "beta_4": _Row("β4", lambda f: f.lemma.beta_4),
    "lemma_1_alpha": _Row("Lemma 1: α under", lambda f: f.lemma.largest_gain),
    "lemma_1_state": _Row("Lemma 1: ‖x‖ to", lambda f: f.lemma.state_bound(0.0, desired=1.0)),
    "loop_radius": _Row("loop's radius", lambda f: f.loop_radius),
    "stable_alpha": _Row("stable: α under", lambda f: f.stable_gain, most=MOST_GAIN),
    "exact_alpha": _Row("α* = 1/ℬt", lambda f: f.exact_gain),
    "inverse_error": _Row("inverse's error", lambda f: f.inverse_error),
}


def figures_table(axes: Sequence[AxisComparison]) -> Table:
    """Every figure of every axis, with its interval; fits 80 columns."""
    table = Table(
        title="in brackets: 95 % confidence intervals",
        box=SIMPLE_HEAD,
        show_edge=False,
        pad_edge=False,
        padding=(0, 1, 0, 0),
    )
    table.add_column(no_wrap=True)
    for axis in axes:
        table.add_column(axis.axis, justify="right", no_wrap=True)
    _add_row(table, "A2 holds", map(_a2, axes))
    _add_row(table, "source: zeros", (_zeros(axis.figures.source) for axis in axes))
    _add_row(table, "target: zeros", (_zeros(axis.figures.target) for axis in axes))
    for row in _ROWS.values():
        _add_row(table, row.title, (_text(_interval(axis, row), row.most) for axis in axes))
    for band, speed in enumerate(_BANDS):
        _add_row(table, f"θ1, {speed}", (_in_band(axis, _theta_1(band)) for axis in axes))
        _add_row(table, f"θ2 (m), {speed}", (_in_band(axis, _theta_2_m(band)) for axis in axes))
    return table


def remarks(axes: Sequence[AxisComparison], judgement: Judgement, record: TrackRecord) -> list[str]:
    """What the table means, then the verdict, how often it was right, and last what to do."""
    said = []
    still = [name for name in AXES if name not in {axis.axis for axis in axes}]
    if still:
        said.append(
            f"{', '.join(still)} left out: one of the two hardly moved there, which tells nothing of it"
        )
    vacuous = [axis.axis for axis in axes if axis.figures.lemma.vacuous]
    if vacuous:
        said.append(
            f"Lemma 1 is vacuous ({', '.join(vacuous)}): its condition fails at α = 0 already. "
            "It is sufficient, not necessary: that it fails says nothing against a transfer."
        )
    said.extend(judgement.reasons)
    share = judgement.confidence
    sure = "" if np.isnan(share) else f" (in {share:.0%} of the resampled flights)"
    return [*said, f"verdict: {judgement.verdict}{sure}", record.in_words(), judgement.verdict.advice]


def as_json(axes: Sequence[AxisComparison], judgement: Judgement, record: TrackRecord) -> dict[str, Any]:
    """The same, and everything else, by names; NaN where something is not known."""
    return {
        "verdict": judgement.verdict,
        "confidence": judgement.confidence,
        "reasons": judgement.reasons,
        "advice": judgement.verdict.advice,
        "record": record.as_json(),
        "axes": {axis.axis: _axis_json(axis) for axis in axes},
    }


def _axis_json(axis: AxisComparison) -> dict[str, Any]:
    f = axis.figures
    return {
        "source": _structure_json(f.source),
        "target": _structure_json(f.target),
        "a2": {
            "holds": f.a2_holds,
            "same_relative_degree": f.same_relative_degree,
            "share_of_resamples": axis.share(lambda each: each.a2_holds),
        },
        "scenario_i_holds": f.lemma.holds(0.0),
        "lemma_1_vacuous": f.lemma.vacuous,
        "figures": {key: _interval(axis, row)._asdict() for key, row in _ROWS.items()},
        "envelope": {speed: _band_json(axis, band) for band, speed in enumerate(_BANDS)},
    }


def _structure_json(structure: Structure) -> dict[str, Any]:
    return {
        "relative_degree": structure.relative_degree,
        "delay_s": structure.delay_s,
        "lead_s": structure.lead_s,
        "zeros": [[float(zero.real), float(zero.imag)] for zero in structure.zeros],
        "minimum_phase": structure.minimum_phase,
    }


def _band_json(axis: AxisComparison, band: int) -> dict[str, Any] | None:
    measure = axis.figures.envelope[band]
    if measure is None:
        return None
    return {
        "theta_1": axis.interval(_theta_1(band))._asdict(),
        "theta_2_m": axis.interval(_theta_2_m(band))._asdict(),
        "share": measure.share,
    }


def _theta_1(band: int) -> Callable[[Figures], float]:
    return lambda f: np.nan if (measure := f.envelope[band]) is None else measure.theta_1


def _theta_2_m(band: int) -> Callable[[Figures], float]:
    return lambda f: np.nan if (measure := f.envelope[band]) is None else measure.theta_2_m


def _interval(axis: AxisComparison, row: _Row) -> Interval:
    found = axis.interval(row.of)
    return Interval(found.value) if row.is_bound else found


def _add_row(table: Table, title: str, cells: Iterable[str]) -> None:
    """Cells as they are: brackets are no markup."""
    table.add_row(title, *map(Text, cells))


def _zeros(structure: Structure) -> str:
    upper = [zero for zero in structure.zeros if zero.imag >= 0.0]
    return ", ".join(_zero(zero) for zero in upper) or "none"


def _zero(zero: complex) -> str:
    return f"{zero.real:z.2f} ± {zero.imag:.2f}j" if zero.imag else f"{zero.real:z.2f}"


def _a2(axis: AxisComparison) -> str:
    answer = "yes" if axis.figures.a2_holds else "no"
    share = axis.share(lambda f: f.a2_holds)
    return answer if np.isnan(share) else f"{answer} [{share:.0%}]"


def _in_band(axis: AxisComparison, of: Callable[[Figures], float]) -> str:
    found = axis.interval(of)
    return "too little flown" if np.isnan(found.value) else _text(found)


def _text(interval: Interval, most: float = np.inf) -> str:
    value, low, high = (_number(figure, most) for figure in interval)
    return f"{value} [–]" if np.isnan(interval.low) else f"{value}\n[{low}, {high}]"


def _number(figure: float, most: float) -> str:
    """Three significant digits, as few characters as they take."""
    if np.isinf(figure):
        return "∞" if figure > 0.0 else "-∞"
    if figure >= most:
        return f"≥ {most:g}"
    short = float(f"{figure:.3g}")
    if abs(short) >= _MOST_DIGITS:
        return f"{short:.3g}".replace("e+0", "e")
    return np.format_float_positional(round(short, _LEAST_DECIMAL) + 0.0, trim="-")
