"""Fidelity figures as JSON and as tables for a terminal."""

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from statistics import median
from typing import Any

import numpy as np
from rich.box import SIMPLE_HEAD
from rich.table import Table
from rich.text import Text

from companion.experiments.fidelity import PooledFidelity, SegmentFidelity, TwinFlight, pooled, rms_axes
from companion.experiments.prediction import HORIZONS_S, Prediction
from companion.experiments.wander import OCTAVES_HZ, WanderComparison


@dataclass(frozen=True, eq=False)
class RecordingFidelity:
    """All that was found for one recording.

    Attributes:
        name: of the recording.
        vehicle: the twin.
        segments: what was flown.
        hover: how both wandered in hover, where that is known.
    """

    name: str
    vehicle: str
    segments: Sequence[SegmentFidelity]
    hover: WanderComparison | None = None

    @property
    def flights(self) -> list[TwinFlight]:
        """Of each segment."""
        return [segment.flight for segment in self.segments]

    @property
    def median_ratio(self) -> float | None:
        """Of the segments that have one."""
        ratios = [flight.ratio for flight in self.flights if flight.ratio is not None]
        return median(ratios) if ratios else None


def hover_line(hover: WanderComparison) -> str:
    """The positions' wander in hover, in words."""
    twin, recorded = (" / ".join(f"{m:.3f}" for m in each.deviation_m) for each in hover)
    return f"hover, north / east / down: the twin wanders by {twin} m, the recorded vehicle by {recorded} m"


def _hover_json(hover: WanderComparison) -> dict[str, Any]:
    """Standard deviations (m), and the twin's power over the recorded one in each octave (Hz), by axis."""
    return {
        "deviation_m": hover.twin.deviation_m.tolist(),
        "recorded_deviation_m": hover.recorded.deviation_m.tolist(),
        "octaves_hz": OCTAVES_HZ,
        "power_ratio": (hover.twin.powers[0] / hover.recorded.powers[0]).tolist(),
    }


def as_json(fidelity: RecordingFidelity) -> dict[str, Any]:
    """One recording's entry of the result; metres."""
    whole = pooled(fidelity.flights)
    return {
        "name": fidelity.name,
        "vehicle": fidelity.vehicle,
        "median_ratio": fidelity.median_ratio,
        "pooled": None if whole is None else asdict(whole) | {"allowed_m2": whole.allowed_m2},
        "hover": None if fidelity.hover is None else _hover_json(fidelity.hover),
        "segments": [
            {
                "id": flight.segment.id,
                "setpoints": flight.segment.setpoints,
                "tracking_rms_m": flight.tracking_rms_m,
                "twin_rms_m": flight.twin_rms_m,
                "ratio": flight.ratio,
                "tracking_rms_axes_m": _axes(flight.tracking_errors),
                "twin_rms_axes_m": _axes(flight.twin_errors),
                "prediction": {f"{horizon_s:g}": asdict(each) for horizon_s, each in predictions.items()},
            }
            for segment in fidelity.segments
            for flight, predictions in [(segment.flight, segment.predictions)]
        ],
    }


def _axes(errors: np.ndarray) -> list[float] | None:
    return rms_axes(errors).tolist() if len(errors) else None


def twin_table(fidelity: RecordingFidelity) -> Table:
    """RMS distances of each segment."""
    table = Table(box=SIMPLE_HEAD, title=f"{fidelity.name} and its twin {fidelity.vehicle}")
    table.add_column("segment", no_wrap=True)
    for head in ("tracking\nRMS (m)", "twin\nRMS (m)", "\nratio", "twin\nnorth", "\neast", "\ndown"):
        table.add_column(head, justify="right")
    for flight in fidelity.flights:
        figures = (flight.tracking_rms_m, flight.twin_rms_m, flight.ratio, *rms_axes(flight.twin_errors))
        table.add_row(Text(flight.segment.id), *map(cell, figures))
    table.add_section()
    table.add_row("median", "", "", cell(fidelity.median_ratio))
    return table


def pooled_line(whole: PooledFidelity) -> str:
    """The criterion for autopilots whose estimate wanders, in one line."""
    said = f"over all segments, for one axis: twin {np.sqrt(whole.twin_m2):.3f} m RMS"
    if whole.allowed_m2 is None or whole.wander_m2 is None:
        return f"{said}; every axis is excited in every segment, so the wander is not known"
    verdict = "within" if whole.twin_m2 <= whole.allowed_m2 else "beyond"
    allowed_m, wander_m, tracking_m = np.sqrt((whole.allowed_m2, whole.wander_m2, whole.tracking_m2))
    return (
        f"{said}, {verdict} the {allowed_m:.3f} m that {wander_m:.3f} m of wander and a quarter of the "
        f"tracking RMS of {tracking_m:.3f} m allow"
    )


def prediction_table(fidelity: RecordingFidelity) -> Table:
    """RMS errors of each segment's predictions, by horizon."""
    table = Table(
        box=SIMPLE_HEAD,
        title=f"{fidelity.name}: positions predicted, RMS error (m)",
        caption="by the online model, by constant velocity, and at the position sent at the time",
    )
    table.add_column("segment", no_wrap=True)
    for horizon_s in HORIZONS_S:
        for head in ("GP", "velocity", "sent"):
            table.add_column(f"{head}\n{horizon_s:g} s", justify="right")
    for segment in fidelity.segments:
        table.add_row(Text(segment.flight.segment.id), *map(cell, _figures(segment.predictions)))
    return table


def _figures(predictions: Mapping[float, Prediction]) -> list[float | None]:
    return [
        getattr(predictions.get(horizon_s), name, None)
        for horizon_s in HORIZONS_S
        for name in ("gp_rms_m", "constant_velocity_rms_m", "setpoint_rms_m")
    ]


def cell(figure: float | None) -> str:
    """A figure as tables show it (m, or a ratio)."""
    return "–" if figure is None else f"{figure:.3f}"
