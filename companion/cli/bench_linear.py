"""`companion bench linear`: the paper's simulation, its figures and its plots."""

from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer
from rich.console import Console
from rich.table import Table

from companion import __version__
from companion.cli.result_file import write_result
from companion.errors import InputError
from companion.experiments.linear.experiment import (
    AMPLIFYING_TARGET,
    TARGET,
    Figures,
    evaluate,
    train_source_network,
)
from companion.experiments.linear.online import PAPER_SETTINGS, OnlineSettings

if TYPE_CHECKING:
    from companion.experiments.linear.noise import NoiseFigures

PAPER = Figures(baseline_rms=3.97, dnn_rms=0.44, dnn_gp_rms=9e-5, prediction_rms=2.9e-7)
ROWS = {
    "baseline_rms": "tracking, baseline",
    "dnn_rms": "tracking, network of the source",
    "dnn_gp_rms": "tracking, network + GP",
    "prediction_rms": "prediction of the error",
}


def linear(
    json: Annotated[Path | None, typer.Option(help="Write the figures to this file.", dir_okay=False)] = None,
    output: Annotated[Path, typer.Option(help="Directory of the plots.", file_okay=False)] = Path(
        "reports/linear"
    ),
    seed: Annotated[
        int, typer.Option(help="Seed of the network's first weights, the probe, and the noise.")
    ] = 0,
    noise_draws: Annotated[
        int, typer.Option(min=0, help="How often each level of measurement noise is drawn; 0: never.")
    ] = 5,
) -> None:
    """Repeat the paper's simulation: one linear system's inverse network steers another, with the online GP.

    Then once more with noise on every measurement, of 1e-4, 1e-3 and 1e-2 of the output's range.

    Example: companion bench linear --json linear.json
    """
    try:
        from companion.experiments.linear.noise import noise_figures
        from companion.experiments.linear.plots import write_figures
    except ModuleNotFoundError as missing:
        raise InputError(
            f"the benchmark needs {missing.name}, which is not installed: pip install 'impromptu[bench]'"
        ) from missing
    output.mkdir(parents=True, exist_ok=True)
    if json is not None:
        json.parent.mkdir(parents=True, exist_ok=True)

    console = Console()
    with console.status("Training the network on the source's response to 25 sinusoids"):
        network = train_source_network(seed=seed)
    with console.status("Running 20,000 steps on the paper's target"):
        pair = evaluate(TARGET, network, OnlineSettings(), seed=seed)
    with console.status("Running 20,000 steps on a target with another input gain"):
        second_pair = evaluate(AMPLIFYING_TARGET, network, OnlineSettings(), seed=seed)
    with console.status("Running 20,000 steps with the paper's quadratic basis, without a probe"):
        paper_settings = evaluate(TARGET, network, PAPER_SETTINGS, seed=seed)
    noisy, seeds = {}, range(seed, seed + noise_draws)
    for name, target in {"paper's pair": TARGET, "second pair": AMPLIFYING_TARGET}.items():
        with console.status(f"Running the {name} with noise, on all cores"):
            noisy[name] = list(noise_figures(target, network, OnlineSettings(), seeds=seeds))
    plots = write_figures(pair, output, name="paper_pair")
    plots += write_figures(second_pair, output, name="second_pair")

    console.print(_table(pair.figures(), paper_settings.figures(), second_pair.figures()))
    if noise_draws:
        console.print(_noise_table(noisy))
    for plot in plots:
        console.print(f"plot: {plot}", soft_wrap=True)
    if json is not None:
        result = asdict(pair.figures()) | {
            "second_pair": asdict(second_pair.figures()),
            "quadratic_basis": asdict(paper_settings.figures()),
            "noise": [asdict(figures) for figures in noisy["paper's pair"]],
            "second_pair_noise": [asdict(figures) for figures in noisy["second pair"]],
            "seed": seed,
            "software": __version__,
        }
        write_result(result, json)


def _table(pair: Figures, quadratic: Figures, second_pair: Figures) -> Table:
    table = Table(title="RMS error over 30 s (20,000 steps)")
    table.add_column("")
    columns = {
        "paper": PAPER,
        "here": pair,
        "here, quadratic basis": quadratic,
        "second pair": second_pair,
    }
    for heading in columns:
        table.add_column(heading, justify="right")
    for key, title in ROWS.items():
        table.add_row(title, *(f"{getattr(figures, key):.3g}" for figures in columns.values()))
    return table


def _noise_table(noisy: dict[str, list["NoiseFigures"]]) -> Table:
    table = Table(title="RMS error with noise on every measurement")
    for heading in ("", "noise", "baseline", "network", "network + GP", "worst ratio", "not worse"):
        table.add_column(heading, justify="right")
    for name, rows in noisy.items():
        for row in rows:
            errors = (row.noise, row.baseline_rms, row.dnn_rms, row.dnn_gp_rms, row.worst_ratio)
            table.add_row(name, *(f"{error:.3g}" for error in errors), f"{row.not_worse} of {row.draws}")
    return table
