"""The fault table: a line for each failure and phase, of all its flights."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass
from statistics import median
from typing import Any

from rich.box import SIMPLE_HEAD
from rich.table import Table

from companion.experiments.faults.catalogue import CRASH_M_S
from companion.experiments.faults.flight import Phase
from companion.experiments.faults.verdict import FLY_AWAY_M, FaultRow

_KEYS = (
    "fault",
    "phase",
    "vehicle",
    "noticed after (s)",
    "by",
    "action",
    "deviation (m)",
    "touch-down (m/s)",
    "lost",
)
_NOTHING = "–"


@dataclass(frozen=True)
class Line:
    """The flights of one vehicle with one failure in one phase.

    Attributes:
        fault, criterion, survivable, phase, vehicle: as in each of their rows.
        flights: how many the fault struck.
        detected_s: median of those in which it was noticed; None where it never was.
        detected_by, actions: all that there were.
        deviation_m, touchdown_m_s: the largest; None where none touched down.
        lost: how many ended in a breach of the fence, a fly-away or a crash.
    """

    fault: str
    criterion: str
    survivable: bool
    phase: Phase
    vehicle: str
    flights: int
    detected_s: float | None
    detected_by: tuple[str, ...]
    actions: tuple[str, ...]
    deviation_m: float
    touchdown_m_s: float | None
    lost: int

    @property
    def cells(self) -> tuple[str, ...]:
        """For a table."""
        return (
            self.fault,
            self.phase,
            self.vehicle,
            _number(self.detected_s),
            ", ".join(self.detected_by) or _NOTHING,
            ", ".join(self.actions),
            _number(self.deviation_m),
            _number(self.touchdown_m_s),
            f"{self.lost} of {self.flights}" if self.lost else "0",
        )


def lines(rows: Iterable[FaultRow]) -> list[Line]:
    """A line for each failure, phase and vehicle, in the order of the rows."""
    groups: dict[tuple[str, Phase, str], list[FaultRow]] = {}
    for row in rows:
        groups.setdefault((row.fault, row.phase, row.vehicle), []).append(row)
    return [_line(group) for group in groups.values()]


def _line(rows: Sequence[FaultRow]) -> Line:
    struck = [row for row in rows if row.struck]
    noticed = [row.detected_s for row in struck if row.detected_s is not None]
    return Line(
        fault=rows[0].fault,
        criterion=rows[0].criterion,
        survivable=rows[0].survivable,
        phase=rows[0].phase,
        vehicle=rows[0].vehicle,
        flights=len(struck),
        detected_s=median(noticed) if noticed else None,
        detected_by=tuple(dict.fromkeys(row.detected_by for row in struck if row.detected_by)),
        actions=tuple(dict.fromkeys(row.action for row in struck)),
        deviation_m=max((row.deviation_m for row in struck), default=0.0),
        touchdown_m_s=max(
            (row.touchdown_m_s for row in struck if row.touchdown_m_s is not None), default=None
        ),
        lost=sum(row.lost for row in struck),
    )


def figures(rows: Sequence[FaultRow]) -> dict[str, Any]:
    """The figures as the benchmark's file holds them."""
    survivable = [row for row in rows if row.survivable and row.struck]
    return {
        "rows": [row.model_dump(mode="json") for row in rows],
        "summary": {
            "kinds": len({row.kind for row in rows}),
            "faults": len({row.fault for row in rows}),
            "flights": len(rows),
            "struck": sum(row.struck for row in rows),
            "survivable": len(survivable),
            "survivable_noticed": sum(row.detected_s is not None for row in survivable),
            "survivable_breaches": sum(row.breach for row in survivable),
            "survivable_fly_aways": sum(row.fly_away for row in survivable),
            "survivable_crashes": sum(row.crash for row in survivable),
        },
        "by_fault": [asdict(line) for line in lines(rows)],
    }


def lost_table(rows: Sequence[FaultRow]) -> Table:
    """For a terminal: the lines in which a flight was lost that can be survived."""
    table = Table(box=SIMPLE_HEAD, caption="lost, though it can be survived")
    for key in _KEYS:
        table.add_column(key, overflow="fold")
    for line in lines(rows):
        if line.lost and line.survivable:
            table.add_row(*line.cells)
    return table


def markdown(rows: Sequence[FaultRow]) -> str:
    """The page docs/faults.md: criteria first, as they were before the flights, then what became of them."""
    every = lines(rows)
    told = figures(rows)["summary"]
    vehicles = list(dict.fromkeys(row.vehicle for row in rows))
    return "\n".join(
        (
            _introduction(vehicles, rows[0].conditions, told),
            "## What can be survived",
            "",
            *_table(
                ("fault", "vehicle", "can be survived", "criterion"),
                (
                    (f"`{fault}`", ", ".join(of), "yes" if survivable else "no", criterion)
                    for (fault, survivable, criterion), of in _criteria(every).items()
                ),
            ),
            "",
            "## What became of it",
            "",
            *_table(_KEYS, ((f"`{fault}`", *cells) for fault, *cells in (line.cells for line in every))),
            "",
        )
    )


def _criteria(every: Iterable[Line]) -> Mapping[tuple[str, bool, str], Iterable[str]]:
    """For which vehicles each criterion holds, and whether they survive by it."""
    criteria: dict[tuple[str, bool, str], dict[str, None]] = {}
    for line in every:
        criteria.setdefault((line.fault, line.survivable, line.criterion), {})[line.vehicle] = None
    return criteria


def _introduction(vehicles: Sequence[str], conditions: str, told: dict[str, int]) -> str:
    return f"""# What fails, and what is done about it

`companion bench faults --json F --markdown docs/faults.md` flies and writes this page:
{" and ".join(vehicles)} in the conditions `{conditions}` with the strategy `dnn+gp`, a landing at the end,
and one fault in each flight, in the climb, on the trajectory or in the landing;
{told["faults"]} faults of {told["kinds"]} kinds, {told["flights"]} flights.
`companion sitl --fault-kinds` says what a fault means.

Lost is a flight that leaves the guard's fence (5 m around its trajectory), comes {FLY_AWAY_M:g} m off
where it should be or drifts on for good, or meets the ground faster than {CRASH_M_S:g} m/s.
Of {told["survivable"]} flights with a fault that can be survived,
{told["survivable_breaches"]} left the fence,
{told["survivable_fly_aways"]} flew away and {told["survivable_crashes"]} crashed.

The time until a fault is noticed is the median of its flights; deviation and touch-down speed are the
largest. Actions that begin with `autopilot:` are its own, without the companion; `yields` leaves the vehicle
to whoever took it.
"""


def _table(head: Sequence[str], body: Iterable[Sequence[str]]) -> Iterable[str]:
    yield f"| {' | '.join(head)} |"
    yield f"|{' - |' * len(head)}"
    for row in body:
        yield f"| {' | '.join(row)} |"


def _number(value: float | None) -> str:
    return _NOTHING if value is None else f"{value:.2f}"
