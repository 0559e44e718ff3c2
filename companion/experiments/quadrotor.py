"""The paper's flights: who flies in them, and what their figures are called."""

from collections.abc import Sequence
from typing import Any

from rich.box import SIMPLE_HEAD
from rich.table import Table

from companion.errors import FlightError, InputError
from companion.experiments.comparison import Comparison, Results, failures, means
from companion.experiments.contenders import (
    SOURCE_OWN,
    TARGET_OWN,
    Contenders,
    Model,
    Several,
    find_model,
    library_for,
    needs_network,
    own_model_name,
    transferred,
    with_own_networks,
)
from companion.experiments.lookahead import measured_lookahead_s
from companion.experiments.results import BASELINE, Cell
from companion.experiments.rows import beside_gp, flight_row
from companion.experiments.simulated_flights import prepare_simulator
from companion.experiments.trajectories import Course
from companion.flight.strategies import Strategy
from companion.learning.library import AUTO
from companion.learning.online_settings import DEFAULT, PAPER, OnlineSettings
from companion.trajectory.trajectory import Trajectory

SUMMARY_KEYS = (*(str(strategy) for strategy in Strategy), TARGET_OWN, SOURCE_OWN)

PAPER_REDUCTIONS = {str(Strategy.DNN): 0.46, str(Strategy.DNN_GP): 0.74, SOURCE_OWN: 0.43}
"""The paper, section "Experiment Results"; `source_own_dnn` on 30 drawings of another paper."""


def paper_comparison(
    trajectories: Sequence[Trajectory],
    *,
    source: str = "ardrone2",
    target: str = "bebop2",
    model: str | None = None,
    strategies: Sequence[Strategy] = tuple(Strategy),
    conditions: str = "ideal",
    seed: int = 0,
    online: OnlineSettings = DEFAULT,
) -> tuple[Comparison, list[str]]:
    """The target with each strategy and, where `dnn` is one of them, each vehicle with its own network.

    Compiles the simulator and measures the target's lookahead, which takes some seconds.

    Args:
        trajectories: NED relative to the takeoff point (m); their names differ.
        source: whose network is carried over: a name in `config/vehicles`, or a YAML file.
        target: what flies with it, named likewise.
        model: the source's network; by default the file of `config/models` with the source's name. `auto`
            for all that are there but the target's, with which only `dnn+gp` flies.
        strategies: besides `baseline`, which is always flown.
        conditions: name in `config/conditions`, or a YAML file.
        seed: of every flight.
        online: settings of the online correction.

    Returns:
        What to fly, and a line for whatever is left out.

    Raises:
        InputError: a vehicle, the conditions or the source's network cannot be used.
    """
    chosen, notes = list(strategies), list[str]()
    of_source: Model | Several | None = None
    if model == AUTO:
        of_source = library_for(target, online)
        if Strategy.DNN in chosen:
            chosen.remove(Strategy.DNN)
            notes.append("dnn was not flown: it takes one network, not several")
    elif any(map(needs_network, chosen)):
        of_source = find_model(model or own_model_name(source, online), online)
    prepare_simulator([source, target], conditions)
    lookahead_s = None
    if Strategy.LOOKAHEAD in chosen:
        try:
            lookahead_s = measured_lookahead_s(target, conditions, seed)
        except FlightError as error:
            chosen.remove(Strategy.LOOKAHEAD)
            notes.append(f"lookahead was not flown: {target} failed on the training sinusoids: {error}")
    contenders = transferred(target, chosen, of_source, lookahead_s)
    if isinstance(of_source, Model) and Strategy.DNN in chosen:
        of_target, why_none = _own_model(target, online)
        notes += why_none
        contenders |= with_own_networks(source, of_source, target, of_target)
    return Comparison(trajectories, contenders, conditions, seed, online), notes


def _own_model(target: str, online: OnlineSettings) -> tuple[Model | None, list[str]]:
    name = own_model_name(target, online)
    try:
        return find_model(name, online), []
    except InputError as error:
        preset = " --preset paper" if online == PAPER else ""
        how = (
            f"make one by `companion collect{preset} --connect sitl://{target} --output {name}.mcap` and "
            f"`companion train{preset} {name}.mcap --output config/models/{name}.safetensors`"
        )
        return None, [f"{TARGET_OWN} was not flown: {error}; {how}"]


def rows_and_summary(courses: Sequence[Course], contenders: Contenders, results: Results) -> dict[str, Any]:
    """The figures as the benchmark's file holds them; null stands for what was not flown or failed.

    `summary` is over all courses, `by_speed` over those of each speed.

    Raises:
        FlightError: not one flight of the target with its baseline came to its end.
    """
    by_name = {course.trajectory.name: course for course in courses}
    rows = [flight_row(by_name[name], contenders[of], result) for (name, of), result in results.items()]
    of_speed = {
        speed_m_s: {
            names: each for names, each in results.items() if by_name[names[0]].speed_m_s == speed_m_s
        }
        for speed_m_s in dict.fromkeys(course.speed_m_s for course in courses)
    }
    return {
        "rows": [row.model_dump(mode="json") for row in beside_gp(rows)],
        "summary": _summary(contenders, results),
        "by_speed": [
            {"speed_m_s": speed_m_s, "summary": _summary(contenders, some)}
            for speed_m_s, some in of_speed.items()
        ],
    }


def _summary(contenders: Contenders, results: Results) -> dict[str, Any]:
    cells = means(contenders, results)
    if BASELINE not in cells:
        raise FlightError(f"no flight with the baseline came to its end: {failures(results)[0]}")
    summary: dict[str, Any] = {"baseline_rms_m": cells[BASELINE].rms_m}
    for key in SUMMARY_KEYS[1:]:
        cell = cells.get(key)
        summary[key] = None if cell is None else {"rms_m": cell.rms_m, "reduction": cell.reduction}
    return summary


def summary_table(cells: dict[str, Cell]) -> Table:
    """Means over the trajectories beside the paper's."""
    table = Table(box=SIMPLE_HEAD, caption="means over the trajectories")
    table.add_column("")
    for heading in ("RMS (m)", "reduction", "paper's"):
        table.add_column(heading, justify="right")
    for key in SUMMARY_KEYS:
        cell, paper = cells.get(key), PAPER_REDUCTIONS.get(key)
        table.add_row(
            key,
            "–" if cell is None else f"{cell.rms_m:.3f}",
            "–" if cell is None or cell.reduction is None else f"{cell.reduction:.2f}",
            "" if paper is None else f"{paper:.2f}",
        )
    return table
