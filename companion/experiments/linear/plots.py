"""The two figures of the paper's simulation (needs matplotlib)."""

from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from companion.experiments.linear.experiment import SAMPLE_TIME_S, Outcome

GREY, GREEN, BLUE, RED = "#8c8c8c", "#70ad47", "#4473c4", "#c00000"


def write_figures(outcome: Outcome, directory: Path, *, name: str) -> list[Path]:
    """Write both figures of one pair as PNG into an existing directory, and give their paths."""
    figures = {
        "predicted_error": predicted_against_exact_error(outcome),
        "outputs": outputs_of_three_strategies(outcome),
    }
    paths = []
    for kind, figure in figures.items():
        paths.append(directory / f"{name}_{kind}.png")
        figure.savefig(paths[-1], dpi=150)
    return paths


def predicted_against_exact_error(outcome: Outcome) -> Figure:
    """The paper's figure of the online module's prediction, and below it the distance from the exact one."""
    figure = Figure(figsize=(8.0, 5.0), layout="constrained")
    errors, distance = figure.subplots(2, 1, sharex=True, height_ratios=(2, 1))
    time_s = SAMPLE_TIME_S * np.arange(len(outcome.desired))

    errors.plot(time_s, outcome.exact_error, color=RED, linewidth=3.5, label="exact, $e_p^*(k+r)$")
    errors.plot(time_s, outcome.predicted_error, color=BLUE, linewidth=1.2, label="predicted, $e_p(k+r)$")
    errors.set_ylabel("error that $u_1$ alone would leave")
    errors.legend()
    errors.grid(alpha=0.3)

    full = slice(outcome.window_full, None)
    misprediction = np.abs(outcome.predicted_error - outcome.exact_error)
    distance.semilogy(time_s[full], misprediction[full], color=BLUE, linewidth=0.4)
    distance.set_ylabel("|predicted − exact|")
    distance.set_xlabel("time (s)")
    distance.grid(alpha=0.3)
    return figure


def outputs_of_three_strategies(outcome: Outcome) -> Figure:
    """The paper's figure of the target's output under the three strategies."""
    figure = Figure(figsize=(8.0, 4.0), layout="constrained")
    axes = figure.subplots()
    time_s = SAMPLE_TIME_S * np.arange(len(outcome.desired))
    rms = outcome.figures()

    strategies = (
        (outcome.baseline, GREY, "baseline", rms.baseline_rms),
        (outcome.dnn, GREEN, "network", rms.dnn_rms),
        (outcome.dnn_gp, BLUE, "network + GP", rms.dnn_gp_rms),
    )
    for track, colour, label, error in strategies:
        axes.plot(time_s, track.outputs, color=colour, linewidth=2.5, label=f"{label}, RMS error {error:.3g}")
    axes.plot(time_s, outcome.desired, color="black", linewidth=1.0, linestyle="--", label="desired")
    axes.set_xlabel("time (s)")
    axes.set_ylabel("output $y$")
    axes.legend(loc="lower center", bbox_to_anchor=(0.5, 1.0), ncols=2, frameon=False)
    axes.grid(alpha=0.3)
    return figure
