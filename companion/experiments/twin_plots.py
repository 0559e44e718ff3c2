"""Pictures of a twin beside the recording that it flew again: each axis, and the distance between both."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from companion.experiments.fidelity import TwinFlight
from companion.experiments.plots import AXES, DESIRED, DPI, clean, north_east_up

RECORDED: dict[str, Any] = {"color": "#D55E00", "linewidth": 1.4, "label": "recorded"}
TWIN: dict[str, Any] = {"color": "#0072B2", "linewidth": 1.1, "label": "twin"}
SENT: dict[str, Any] = DESIRED | {"label": "sent"}
MOST_SEGMENTS = 6
"""More side by side could not be made out."""


def plot_twin(flights: Sequence[TwinFlight], path: Path) -> None:
    """Draw position over time by axis, and the distance of twin and recording, a column for each segment.

    Of more than `MOST_SEGMENTS` segments, the longest are drawn.
    """
    longest = sorted(flights, key=lambda flight: -np.ptp(flight.time_s))[:MOST_SEGMENTS]
    shown = [flight for flight in flights if flight in longest]
    figure = Figure(figsize=(4.0 + 5.0 * len(shown), 9.0), layout="constrained")
    panels = figure.subplots(4, len(shown), sharex="col", squeeze=False)
    for column, flight in zip(panels.T, shown, strict=True):
        _draw(flight, column)
    for panel, name in zip(panels[:, 0], (*AXES, "distance"), strict=True):
        panel.set_ylabel(f"{name} (m)")
    figure.legend(
        *panels[0, 0].get_legend_handles_labels(), loc="outside upper center", ncols=3, frameon=False
    )
    figure.savefig(path, dpi=DPI)


def _draw(flight: TwinFlight, panels: Sequence[Axes]) -> None:
    time_s = flight.time_s - flight.time_s[0]
    for axis, panel in enumerate(panels[:3]):
        for positions, style in ((flight.sent, SENT), (flight.recorded, RECORDED), (flight.twin, TWIN)):
            panel.plot(time_s, north_east_up(positions)[:, axis], **style)
    panels[3].plot(time_s, np.linalg.norm(flight.twin_errors, axis=1), color=TWIN["color"], linewidth=1.1)
    panels[3].set_ylim(bottom=0.0)
    panels[3].set_xlabel("time (s)")
    panels[0].set_title(f"{flight.segment.id}: {flight.twin_rms_m:.3f} m", fontsize=11)
    for panel in panels:
        clean(panel)
