"""Pictures of flights: path, position and error over time, RMS errors side by side.

Positions are drawn as north, east and up, since people read heights upwards. A strategy has the same colour
everywhere; the colours are those that Okabe and Ito chose to be told apart by everyone
(https://jfly.uni-koeln.de/color/).
"""

from collections.abc import Sequence
from itertools import cycle, islice
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from companion.arrays import Array, Vec3s
from companion.experiments.flights import Flight
from companion.experiments.results import RmsErrors, strategies_of, trajectories_of

COLOURS = {
    "baseline": "#D55E00",
    "feedforward": "#E69F00",
    "lookahead": "#009E73",
    "dnn": "#CC79A7",
    "gp": "#56B4E9",
    "dnn+gp": "#0072B2",
}
OTHER_COLOUR = "#555555"
DESIRED = {"color": "#BBBBBB", "linewidth": 4.0, "solid_capstyle": "round", "label": "desired"}
AXES = ("north", "east", "up")
DPI = 144
_GAP_S = 1.0


def colour_of(strategy: str) -> str:
    """The colour of a strategy in every picture."""
    return COLOURS.get(strategy, OTHER_COLOUR)


def colours_of(flights: Sequence[Flight]) -> list[str]:
    """A colour for each flight: its strategy's, or where those do not tell them apart, one after another."""
    usual = [colour_of(flight.strategy) for flight in flights]
    if len(set(usual)) == len(flights):
        return usual
    return list(islice(cycle((*COLOURS.values(), OTHER_COLOUR)), len(flights)))


def plot_paths(flights: Sequence[Flight], path: Path) -> None:
    """Draw desired against flown path of one trajectory in its plane, a panel for each strategy.

    Here and over time, lines are broken where nothing is known for a second or more.
    """
    whole = _longest(flights).desired
    horizontal, vertical = plane_of(whole)
    columns = min(3, len(flights))
    rows = -(-len(flights) // columns)
    width, height = np.ptp(north_east_up(whole)[:, [horizontal, vertical]], axis=0)
    panel_height = 0.6 + 3.2 * float(np.clip(height / max(width, 1e-6), 0.4, 1.6))
    figure = Figure(figsize=(3.4 * columns, panel_height * rows), layout="constrained")
    panels = figure.subplots(rows, columns, sharex=True, sharey=True, squeeze=False).ravel()
    for panel, flight, colour in zip(panels, flights, colours_of(flights), strict=False):
        desired, flown = (broken(flight, north_east_up(each)) for each in (flight.desired, flight.flown))
        panel.plot(desired[:, horizontal], desired[:, vertical], **DESIRED)
        panel.plot(flown[:, horizontal], flown[:, vertical], color=colour, linewidth=1.4)
        panel.plot(*flown[0, [horizontal, vertical]], "o", color=colour, markersize=5)
        name = flight.strategy.replace(" (", "\n(")
        panel.set_title(f"{name}: {flight.rms_m:.3f} m", fontsize=11)
        panel.set_aspect("equal")
        clean(panel)
    for panel in panels[len(flights) :]:
        panel.remove()
    figure.supxlabel(f"{AXES[horizontal]} (m)", fontsize=10)
    figure.supylabel(f"{AXES[vertical]} (m)", fontsize=10)
    figure.savefig(path, dpi=DPI)


def plot_over_time(flights: Sequence[Flight], path: Path) -> None:
    """Draw each axis, desired against flown, and the error, over the time of one trajectory."""
    figure = Figure(figsize=(10.2, 9.0), layout="constrained")
    panels = figure.subplots(4, 1, sharex=True)
    whole = _longest(flights)
    desired = broken(whole, north_east_up(whole.desired))
    for axis, panel in enumerate(panels[:3]):
        panel.plot(broken(whole, whole.along_s), desired[:, axis], **DESIRED)
        panel.set_ylabel(f"{AXES[axis]} (m)")
    panels[3].set_ylabel("error (m)")
    panels[3].set_xlabel("time (s)")
    for flight, colour in zip(flights, colours_of(flights), strict=True):
        time_s = broken(flight, flight.along_s)
        flown = broken(flight, north_east_up(flight.flown))
        style = {"color": colour, "linewidth": 1.3, "label": flight.strategy}
        for axis, panel in enumerate(panels[:3]):
            panel.plot(time_s, flown[:, axis], **style)
        panels[3].plot(time_s, broken(flight, np.linalg.norm(flight.flown - flight.desired, axis=1)), **style)
    for panel in panels:
        clean(panel)
    panels[3].set_ylim(bottom=0.0)
    figure.legend(*panels[0].get_legend_handles_labels(), loc="outside upper center", ncols=7, frameon=False)
    figure.savefig(path, dpi=DPI)


def plot_rms(rms_m: RmsErrors, path: Path) -> None:
    """Draw the RMS error of each trajectory with each strategy, as bars."""
    trajectories, strategies = trajectories_of(rms_m), strategies_of(rms_m)
    figure = Figure(figsize=(10.2, 3.6), layout="constrained")
    panel = figure.subplots()
    width = 0.84 / len(strategies)
    places = np.arange(len(trajectories))
    for i, strategy in enumerate(strategies):
        heights = [rms_m.get((trajectory, strategy), np.nan) for trajectory in trajectories]
        offset = (i - (len(strategies) - 1) / 2.0) * width
        panel.bar(places + offset, heights, 0.92 * width, color=colour_of(strategy), label=strategy)
    panel.margins(x=0.01)
    panel.set_xticks(places, trajectories)
    panel.tick_params(axis="x", length=0)
    panel.set_ylabel("RMS error (m)")
    clean(panel)
    panel.grid(visible=False, axis="x")
    figure.legend(loc="outside upper center", ncols=6, frameon=False)
    figure.savefig(path, dpi=DPI)


def plane_of(desired: Vec3s) -> tuple[int, int]:
    """The axes (of north, east, up) in which the path lies: which to draw to the right, which upwards.

    They are the two along which it extends most; of north and east alone, north goes up, as on a map.
    """
    narrowest = int(np.argmin(np.ptp(desired, axis=0)))
    return {0: (1, 2), 1: (0, 2), 2: (1, 0)}[narrowest]


def north_east_up(position: Vec3s) -> Vec3s:
    """Positions as they are drawn, from NED (m)."""
    drawn: Vec3s = position * np.array([1.0, 1.0, -1.0])
    return drawn


def _longest(flights: Sequence[Flight]) -> Flight:
    """The flight of which most is known: others may have been cut short."""
    return max(flights, key=lambda flight: len(flight.time_s))


def broken(flight: Flight, values: Array) -> Array:
    """`values` at the times of `flight`, with a NaN in each of its gaps, where lines end."""
    gaps = np.flatnonzero(np.diff(flight.time_s) > _GAP_S) + 1
    broken: Array = np.insert(values, gaps, np.nan, axis=0)
    return broken


def clean(panel: Axes) -> None:
    """Give a panel the look of all."""
    panel.grid(visible=True, color="#E4E4E4", linewidth=0.8)
    panel.set_axisbelow(True)
    panel.spines[["top", "right"]].set_visible(False)
    panel.spines[["left", "bottom"]].set_color("#888888")
    panel.tick_params(labelsize=9, color="#888888")
