"""A page on one or several flights, from their logs: a folder that is readable without a network."""

from collections.abc import Sequence
from html import escape
from itertools import groupby
from pathlib import Path

from companion.errors import InputError
from companion.experiments.logged_flights import LoggedFlight
from companion.experiments.page import page, paths_section, typed

COLUMNS = ("trajectory", "strategy", "vehicle", "time (s)", "RMS (m)", "max (m)", "u2 (m)")
_MOST_EVENTS = 200


def table_row(logged: LoggedFlight) -> tuple[str, ...]:
    """The cells of `COLUMNS`."""
    flight, longest_m = logged.flight, logged.largest_correction_m
    return (
        flight.trajectory_name,
        flight.strategy,
        logged.recording.provenance.vehicle,
        f"{flight.time_s[-1] - flight.time_s[0]:.1f}",
        f"{logged.accuracy.rms_m:.3f}",
        f"{logged.accuracy.max_m:.3f}",
        "–" if longest_m is None else f"{longest_m:.3f}",
    )


def write_flight_report(flights: Sequence[LoggedFlight], directory: Path, command: str) -> Path:
    """Write `index.html` and its pictures into `directory`, which is made where it is missing.

    Args:
        flights: at least one; those of one trajectory are drawn together.
        directory: where to write; files of an earlier report there are replaced.
        command: what to type to make the same report.

    Returns:
        The page.

    Raises:
        InputError: when the directory cannot be written, or the extra `bench` is not installed.
    """
    try:
        from companion.experiments import flight_plots, plots
    except ModuleNotFoundError as error:
        raise InputError(
            f"pictures need {error.name}, which the extra `bench` brings: pip install 'impromptu[bench]'"
        ) from error
    sections = [_table(flights)]
    try:
        directory.mkdir(parents=True, exist_ok=True)
        ordered = sorted(flights, key=lambda each: each.flight.trajectory_name)
        by_trajectory = groupby(ordered, key=lambda each: each.flight.trajectory_name)
        for number, (name, group) in enumerate(by_trajectory, start=1):
            of_this = [each.flight for each in group]
            plots.plot_paths(of_this, directory / f"{number:02d}-path.png")
            plots.plot_over_time(of_this, directory / f"{number:02d}-time.png")
            sections.append(paths_section(name, f"{number:02d}", "flight"))
        for number, each in enumerate(flights, start=1):
            picture = directory / f"flight-{number:02d}.png"
            tracking, (start_s, end_s) = each.recording.tracking, each.flight.time_s[[0, -1]]
            drawn = tracking is not None and flight_plots.plot_control(tracking, start_s, end_s, picture)
            sections.append(_flight_section(each, picture.name if drawn else None))
        index = directory / "index.html"
        index.write_text(page("Flights", "".join((*sections, typed([command])))), encoding="utf-8")
    except OSError as error:
        raise InputError(f"{directory}: the report cannot be written there ({error.strerror})") from error
    return index


def _table(flights: Sequence[LoggedFlight]) -> str:
    heads = "".join(f'<th scope="col">{escape(column)}</th>' for column in COLUMNS)
    body = "\n".join(map(_html_row, flights))
    return f"""<div class="wide"><table>
<thead><tr>{heads}</tr></thead>
<tbody>
{body}
</tbody>
</table></div>
<p class="note">Errors are against the vehicle's own estimate, along the trajectory; u2 is the longest
correction.</p>
"""


def _html_row(logged: LoggedFlight) -> str:
    first, *others = map(escape, table_row(logged))
    return f'<tr><th scope="row">{first}</th>{"".join(f"<td>{cell}</td>" for cell in others)}</tr>'


def _flight_section(logged: LoggedFlight, picture: str | None) -> str:
    recording, name = logged.recording, escape(logged.path.name)
    told = recording.provenance.model_dump(mode="json") | dict(recording.made_by)
    facts = {key: value for key, value in told.items() if value not in (None, "")}
    listed = "".join(f"<dt>{escape(key)}</dt><dd>{escape(str(value))}</dd>" for key, value in facts.items())
    figure = (
        f'<figure><img src="{picture}" alt="{name}: reference and correction"></figure>' if picture else ""
    )
    start_s = logged.flight.time_s[0]
    events = recording.events
    left_out = f"\n… and {len(events) - _MOST_EVENTS} more" if len(events) > _MOST_EVENTS else ""
    said = "\n".join(f"{time_s - start_s:8.2f} s  {text}" for time_s, text in events[:_MOST_EVENTS])
    return f"""<section>
<h2>{name}</h2>
<dl>{listed}</dl>
{figure}
<pre>{escape(said + left_out)}</pre>
</section>
"""
