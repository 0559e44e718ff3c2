"""A page on recordings and their twins: a folder that is readable without a network."""

from collections.abc import Sequence
from html import escape
from pathlib import Path

from companion.errors import InputError
from companion.experiments.fidelity import TwinFlight, pooled
from companion.experiments.fidelity_tables import RecordingFidelity, cell, pooled_line
from companion.experiments.page import page, typed
from companion.experiments.twin_plots import plot_twin


def write_fidelity_report(fidelities: Sequence[RecordingFidelity], directory: Path, command: str) -> Path:
    """Write `index.html` and a picture for each segment into `directory`, and say where the page is.

    Raises:
        InputError: the directory cannot be written.
    """
    try:
        directory.mkdir(parents=True, exist_ok=True)
        sections = [
            _section(fidelity, directory, number) for number, fidelity in enumerate(fidelities, start=1)
        ]
        index = directory / "index.html"
        body = "".join((*sections, typed([command])))
        index.write_text(page("Twins against recordings", body), encoding="utf-8")
    except OSError as error:
        raise InputError(f"{directory}: the report cannot be written there ({error.strerror})") from error
    return index


def _section(fidelity: RecordingFidelity, directory: Path, number: int) -> str:
    figures = []
    for place, flight in enumerate(fidelity.flights, start=1):
        picture = f"{number:02d}-{place:02d}.png"
        plot_twin([flight], directory / picture)
        title = escape(flight.segment.id)
        figures.append(f'<figure><img src="{picture}" alt="{title}: sent, recorded and twin"></figure>')
    whole = pooled(fidelity.flights)
    return f"""<section>
<h2>{escape(fidelity.name)} and its twin {escape(fidelity.vehicle)}</h2>
<div class="wide"><table class="total">
<thead><tr><th scope="col">segment</th><th>tracking RMS (m)</th><th>twin RMS (m)</th><th>ratio</th></tr>
</thead>
<tbody>
{"".join(map(_row, fidelity.flights))}
<tr><th scope="row">median</th><td></td><td></td><td>{cell(fidelity.median_ratio)}</td></tr>
</tbody>
</table></div>
<p class="note">{"" if whole is None else escape(pooled_line(whole))}</p>
{"".join(figures)}
</section>
"""


def _row(flight: TwinFlight) -> str:
    cells = map(cell, (flight.tracking_rms_m, flight.twin_rms_m, flight.ratio))
    return f'<tr><th scope="row">{escape(flight.segment.id)}</th><td>{"</td><td>".join(cells)}</td></tr>\n'
