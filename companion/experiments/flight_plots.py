"""Pictures of what the control loop did in a flight: reference, correction, its gain, and its confidence."""

from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from companion.arrays import Times
from companion.experiments.plots import AXES, DPI, clean, north_east_up
from companion.recording.series import TrackingSeries, rows

_COLOURS = ("#D55E00", "#0072B2", "#009E73")


def plot_control(tracking: TrackingSeries, start_s: float, end_s: float, path: Path) -> bool:
    """Draw what was added to the desired position, α and the predicted deviation, between two times (s).

    Returns:
        Whether there was anything to draw: the baseline adds nothing.
    """
    within = np.flatnonzero((tracking.time_s >= start_s) & (tracking.time_s <= end_s))
    shown = rows(tracking, within)
    time_s: Times = shown.time_s - start_s
    panels_of = {
        "u1 − desired (m)": north_east_up(shown.u1 - shown.desired_position),
        "u2 (m)": north_east_up(shown.u2),
        "gain α": shown.alpha,
        "predicted std (m)": np.sqrt(shown.predicted_variance),
    }
    drawn = {name: columns for name, columns in panels_of.items() if np.nan_to_num(columns).any()}
    if not drawn:
        return False
    figure = Figure(figsize=(10.2, 0.6 + 2.1 * len(drawn)), layout="constrained")
    panels = figure.subplots(len(drawn), 1, sharex=True, squeeze=False)[:, 0]
    for panel, (name, columns) in zip(panels, drawn.items(), strict=True):
        for axis, colour, values in zip(AXES, _COLOURS, columns.T, strict=True):
            panel.plot(time_s, values, color=colour, linewidth=1.1, label=axis)
        panel.set_ylabel(name)
        clean(panel)
    panels[-1].set_xlabel("time (s)")
    figure.legend(*panels[0].get_legend_handles_labels(), loc="outside upper center", ncols=3, frameon=False)
    figure.savefig(path, dpi=DPI)
    return True
