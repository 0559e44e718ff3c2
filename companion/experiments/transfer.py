"""Every network on every other vehicle: what transfer is worth, and how often it does harm."""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import asdict, dataclass
from typing import Any, NamedTuple

import numpy as np
from rich.box import SIMPLE_HEAD
from rich.table import Table

from companion.experiments.backend import LOCAL, Backend
from companion.experiments.contenders import Contender, Model, find_model, own_model_name, transferred
from companion.experiments.fingerprint import fingerprint
from companion.experiments.rows import FlightRow, beside_gp, flight_row
from companion.experiments.simulated_flights import Result, Scenario, evaluate_all, prepare_simulator
from companion.experiments.trajectories import Course
from companion.flight.strategies import Strategy
from companion.learning.online_settings import DEFAULT, OnlineSettings
from sitl.conditions import load_conditions
from sitl.vehicle import load_vehicle

VEHICLES = ("ardrone2", "bebop2", "x500", "crazyflie", "iris")
CONDITIONS = ("ideal", "realistic", "px4")

_HARM = 0.05
_HARM_M = 0.01
"""A flight is worse than the baseline where its RMS error is larger by more than both."""


class TransferRow(FlightRow):
    """A flight of a target, with whose network it flew; null where with none."""

    source: str | None
    target: str


class TransferFlight(NamedTuple):
    """A flight that is to be flown, by a target with a source's network or with none."""

    source: str | None
    course: Course
    contender: Contender
    scenario: Scenario

    def row(self, result: Result) -> TransferRow:
        """What came of it."""
        row = flight_row(self.course, self.contender, result)
        return TransferRow(**row.model_dump(), source=self.source, target=self.contender.vehicle)


@dataclass(frozen=True, eq=False)
class Transfer:
    """All ordered pairs of vehicles in all conditions on all courses, with each target's baseline and `gp`.

    Attributes:
        models: each vehicle's own network, by the vehicle's name.
        conditions: names in `config/conditions`, or YAML files.
        courses: what is flown.
        seed: of every flight.
        online: settings of the online correction.
    """

    models: dict[str, Model]
    conditions: Sequence[str]
    courses: Sequence[Course]
    seed: int = 0
    online: OnlineSettings = DEFAULT

    def flights(self) -> list[TransferFlight]:
        """What is to be flown, always in the same order."""
        return [
            TransferFlight(
                source,
                course,
                contender,
                contender.scenario(course.trajectory, conditions, self.seed, self.online),
            )
            for conditions in self.conditions
            for target in self.models
            for course in self.courses
            for source, contender in self._contenders(target)
        ]

    def _contenders(self, target: str) -> list[tuple[str | None, Contender]]:
        plain = transferred(target, [Strategy.GP], None, None)
        return [(None, contender) for contender in plain.values()] + [
            (source, Contender(target, Strategy.DNN_GP, model))
            for source, model in self.models.items()
            if source != target
        ]

    def prepare(self) -> None:
        """Compile the simulator, once for all cores; InputError where a vehicle or conditions are wrong."""
        for conditions in self.conditions:
            prepare_simulator(list(self.models), conditions)

    def fingerprint(self) -> str:
        """The same only for a job that gives the same rows."""
        return fingerprint(self._given())

    def _given(self) -> Iterator[bytes]:
        yield f"{self.seed} {self.online.model_dump_json()}".encode()
        for vehicle, model in self.models.items():
            yield load_vehicle(vehicle).model_dump_json().encode()
            yield model.network.card.model_dump_json().encode()
            yield from (layer.weight.tobytes() for layer in model.network.layers)
        for conditions in self.conditions:
            yield load_conditions(conditions).model_dump_json().encode()
        for course in self.courses:
            yield course.drawing.encode()
            yield course.trajectory.coefficients.tobytes()


def own_models(vehicles: Iterable[str], online: OnlineSettings = DEFAULT) -> dict[str, Model]:
    """Each vehicle's own network; InputError where one has none."""
    return {vehicle: find_model(own_model_name(vehicle, online), online) for vehicle in vehicles}


def fly(flights: Sequence[TransferFlight], backend: Backend = LOCAL) -> Iterator[TransferRow]:
    """The rows of the flights, in their order, as they end."""
    results = evaluate_all([flight.scenario for flight in flights], backend)
    return (flight.row(result) for flight, result in zip(flights, results, strict=True))


@dataclass(frozen=True)
class TransferSummary:
    """Flights with another vehicle's network against the baseline's on the same course.

    Attributes:
        mean_reduction: mean of 1 − rms / baseline's; None where none can be compared.
        worst_ratio: the largest rms / baseline's.
        flights: how many, those included that failed.
        worse_than_baseline: how many were worse by more than 5 % and more than 1 cm, or failed.
    """

    mean_reduction: float | None
    worst_ratio: float | None
    flights: int
    worse_than_baseline: int


def summary(rows: Iterable[TransferRow]) -> TransferSummary:
    """The summary of these rows, among which each baseline is."""
    rows = list(rows)
    of_baseline = {_place(row): row.rms_m for row in rows if row.strategy == Strategy.BASELINE}
    with_network = [row for row in rows if row.source is not None]
    pairs = [(row.rms_m, of_baseline[_place(row)]) for row in with_network]
    ratios = [rms / baseline for rms, baseline in pairs if rms is not None and baseline is not None]
    return TransferSummary(
        mean_reduction=1.0 - float(np.mean(ratios)) if ratios else None,
        worst_ratio=max(ratios, default=None),
        flights=len(with_network),
        worse_than_baseline=sum(_is_worse(rms, baseline) for rms, baseline in pairs),
    )


def _is_worse(rms_m: float | None, baseline_m: float | None) -> bool:
    if rms_m is None or baseline_m is None:
        return rms_m is None
    return rms_m - baseline_m > max(_HARM * baseline_m, _HARM_M)


def _place(row: TransferRow) -> tuple[str, str, str]:
    return row.target, row.conditions, row.trajectory


def figures(rows: Sequence[TransferRow]) -> dict[str, Any]:
    """The figures as the benchmark's file holds them."""
    by_conditions = {
        conditions: asdict(summary(row for row in rows if row.conditions == conditions))
        for conditions in dict.fromkeys(row.conditions for row in rows)
    }
    return {
        "rows": [row.model_dump(mode="json") for row in beside_gp(rows)],
        "summary": asdict(summary(rows)),
        "by_conditions": by_conditions,
    }


def pair_table(rows: Sequence[TransferRow], conditions: str) -> Table:
    """Mean reduction of each source's network on each target in these conditions."""
    there = [row for row in rows if row.conditions == conditions]
    targets = list(dict.fromkeys(row.target for row in there))
    table = Table(box=SIMPLE_HEAD, caption=f"{conditions}: mean reduction, worst ratio in brackets")
    table.add_column("network of")
    for target in targets:
        table.add_column(target, justify="right")
    for source in targets:
        cells = [
            "" if source == target else _pair_cell([row for row in there if row.target == target], source)
            for target in targets
        ]
        table.add_row(source, *cells)
    return table


def _pair_cell(rows: Iterable[TransferRow], source: str) -> str:
    told = summary(row for row in rows if row.source in (source, None))
    if told.mean_reduction is None:
        return "–"
    return f"{told.mean_reduction:.2f} ({told.worst_ratio:.2f})"
