"""A report on several flights: a folder with one page and its pictures, readable without a network."""

import re
from collections.abc import Mapping, Sequence
from html import escape
from pathlib import Path

from companion.errors import InputError
from companion.experiments.flights import Flight
from companion.experiments.page import page, paths_section, typed
from companion.experiments.results import Cell, RmsErrors, results_rows, strategies_of, trajectories_of


def write_report(
    flights: Sequence[Flight],
    directory: Path,
    *,
    title: str,
    conditions: Mapping[str, str],
    commands: Sequence[str],
) -> Path:
    """Write `index.html` and its pictures into `directory`, which is made where it is missing.

    Args:
        flights: at least one; in the order in which strategies and trajectories shall appear.
        directory: where to write; files of an earlier report there are replaced.
        title: heading of the page.
        conditions: what the flights were flown with, in words: vehicle, model, wind, seed.
        commands: what to type to make the same report.

    Returns:
        The page.

    Raises:
        InputError: when the directory cannot be written, or the extra `bench` is not installed.
    """
    try:
        from companion.experiments import plots
    except ModuleNotFoundError as error:
        raise InputError(
            f"a report needs {error.name}, which the extra `bench` brings: pip install 'impromptu[bench]'"
        ) from error
    rms_m = {(flight.trajectory_name, flight.strategy): flight.rms_m for flight in flights}
    sections = []
    try:
        directory.mkdir(parents=True, exist_ok=True)
        plots.plot_rms(rms_m, directory / "rms.png")
        for number, name in enumerate(trajectories_of(rms_m), start=1):
            of_this = [flight for flight in flights if flight.trajectory_name == name]
            stem = f"{number:02d}-{_file_name(name)}"
            plots.plot_paths(of_this, directory / f"{stem}-path.png")
            plots.plot_over_time(of_this, directory / f"{stem}-time.png")
            sections.append(paths_section(name, stem, "strategy"))
        colours = {strategy: plots.colour_of(strategy) for strategy in strategies_of(rms_m)}
        index = directory / "index.html"
        index.write_text(
            _page(title, conditions, _table(rms_m, colours), sections, commands), encoding="utf-8"
        )
    except OSError as error:
        raise InputError(f"{directory}: the report cannot be written there ({error.strerror})") from error
    return index


def _file_name(name: str) -> str:
    return re.sub(r"[^A-Za-z0-9]+", "-", name).strip("-").lower()[:40] or "trajectory"


def _table(rms_m: RmsErrors, colours: Mapping[str, str]) -> str:
    heads = "".join(
        f'<th scope="col"><i style="background:{colour}"></i>{escape(strategy)}</th>'
        for strategy, colour in colours.items()
    )
    rows = "\n".join(
        f'<tr><th scope="row">{escape(name)}</th>{"".join(map(_table_cell, cells))}</tr>'
        for name, cells in results_rows(rms_m)
    )
    return f"""<table class="total">
<thead><tr><th scope="col">trajectory</th>{heads}</tr></thead>
<tbody>
{rows}
</tbody>
</table>"""


def _table_cell(cell: Cell | None) -> str:
    if cell is None:
        return "<td>–</td>"
    change = "" if cell.reduction is None else f"<small>{cell.change}</small>"
    return f"<td>{cell.rms_m:.3f}{change}</td>"


def _page(
    title: str, conditions: Mapping[str, str], table: str, sections: Sequence[str], commands: Sequence[str]
) -> str:
    facts = "\n".join(f"<dt>{escape(key)}</dt><dd>{escape(value)}</dd>" for key, value in conditions.items())
    return page(
        title,
        f"""<dl>
{facts}
</dl>
<h2>RMS error</h2>
<div class="wide">{table}</div>
<p class="note">In metres, from the first to the last instant of each trajectory; beneath, the change against
the baseline. The mean of the changes is taken over trajectories.</p>
<figure><img src="rms.png" alt="RMS error of each trajectory with each strategy"></figure>
{"".join(sections)}
{typed(commands)}""",
    )
