"""`companion bench pairs`: the linear experiment over random pairs of systems."""

from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console
from rich.progress import track
from rich.table import Table

from companion import __version__
from companion.cli import options
from companion.cli.result_file import write_result
from companion.errors import InputError

try:
    from companion.experiments.fingerprint import fingerprint
    from companion.experiments.journal import Journal
    from companion.experiments.linear.pairs import PairRow, PairsSummary, fly_pairs, summarise
except ModuleNotFoundError as missing:
    raise InputError(
        f"the benchmark needs {missing.name}, which is not installed: pip install 'impromptu[bench]'"
    ) from missing


def pairs(
    count: Annotated[int, typer.Option(min=1, help="How many pairs.")] = 1000,
    noise: Annotated[
        float,
        typer.Option(min=0.0, help="Measurement noise: standard deviation over the desired output's range."),
    ] = 0.0,
    seed: options.Seed = 0,
    json: options.Json = None,
) -> None:
    """Let the inverse of one random linear system steer another, with the online correction under a guard.

    All systems are stable and minimum phase; source and target share order and relative degree. With --json
    FILE, each pair is kept in FILE.pairs as it ends: the same command goes on from there after it was
    stopped.

    FILE has `summary` (pairs, diverged, median_ratio, worst_ratio, worse_than_baseline,
    network_diverged_share, fell_back_share, fallback_steps_share, lemma_held_share, lemma_bounds_share,
    lemma_conservatism_median) and `rows`, one for each pair; docs/linear.md says what each is.

    Example: companion bench pairs --json pairs.json

    Example: companion bench pairs --count 100 --noise 0.01
    """
    if json is not None:
        options.writable(json)
    console = Console()
    rows = _fly(count, noise, seed, json, console)
    summary = summarise(rows)
    console.print(_table(summary))
    if json is not None:
        write_result(
            {
                "rows": [row.model_dump() for row in rows],
                "summary": summary.model_dump(),
                "settings": {"count": count, "noise": noise, "seed": seed},
                "software": __version__,
            },
            json,
        )
        _journal_of(json).unlink()


def _journal_of(json: Path) -> Path:
    return json.with_name(f"{json.name}.pairs")


def _fly(count: int, noise: float, seed: int, json: Path | None, console: Console) -> list[PairRow]:
    """All rows of the job, some of them perhaps flown before."""
    if json is None:
        flown = fly_pairs(range(count), seed=seed, noise=noise)
        return list(track(flown, "Flying", count, console=console, transient=True))
    job = fingerprint([f"pairs {count} {noise} {seed}".encode()])
    journal = Journal(_journal_of(json), PairRow, belongs_to=job, most=count)
    done = len(journal.rows)
    if done:
        console.print(f"{done} of {count} pairs were flown before")
    rest = fly_pairs(range(done, count), seed=seed, noise=noise)
    for row in track(rest, "Flying", count, completed=done, console=console, transient=True):
        journal.append(row)
    return journal.rows


def _table(summary: PairsSummary) -> Table:
    table = Table(title=f"{summary.pairs} random pairs of linear systems", show_header=False)
    table.add_column("")
    table.add_column("", justify="right")
    pairs_back, steps_back = summary.fell_back_share, summary.fallback_steps_share
    conservatism = summary.lemma_conservatism_median
    figures = {
        "diverged, guarded network + GP": f"{summary.diverged}",
        "diverged, network alone": f"{summary.network_diverged_share:.1%}",
        "RMS over baseline, median": f"{summary.median_ratio:.3g}",
        "RMS over baseline, worst": f"{summary.worst_ratio:.3g}",
        "worse than baseline": f"{summary.worse_than_baseline}",
        "fell back": f"{pairs_back:.1%} of the pairs, {steps_back:.2%} of the steps",
        "Lemma 1 held at the gain used": f"{summary.lemma_held_share:.1%}",
        "Lemma 1 holds at some gain": f"{summary.lemma_bounds_share:.1%}",
        "there, its bound over the largest stable gain": "-"
        if conservatism is None
        else f"{conservatism:.3g}",
    }
    for name, figure in figures.items():
        table.add_row(name, figure)
    return table
