"""A flight as the files of the benchmarks hold it: one row, whose keys these are."""

from collections.abc import Iterable
from typing import TypeVar

from pydantic import BaseModel, ConfigDict

from companion.experiments.contenders import Contender
from companion.experiments.simulated_flights import Failed, Result
from companion.experiments.trajectories import Course
from companion.flight.strategies import Strategy


class FlightRow(BaseModel):
    """One flight of a benchmark; null is what a flight does not have or what a failed one does not show.

    Attributes:
        vehicle: which flew.
        strategy: how.
        model: name of the network's file.
        conditions: name in `config/conditions`, or a YAML file.
        trajectory: name of the drawing.
        plane: in which it was laid.
        speed_m_s: peak speed that was asked for; null where none was.
        reached_m_s: peak speed of the trajectory, within what the vehicles can do.
        rms_m: RMS error, against the truth or as the conditions say.
        rms_estimate_m: against the vehicle's own estimate.
        rms_axes_m: north, east, down.
        max_m: the largest error.
        active_share: share of the time in which the network was active.
        gp_rms_m: RMS error of `gp` on the same flight.
        event_s: when the vehicle changed in flight, on the trajectory.
        recovery_s: from then until the error was back under twice its RMS before; null if it never was.
        guard: how often the guard changed what.
        error: why the flight failed.
    """

    model_config = ConfigDict(frozen=True, extra="forbid")

    vehicle: str
    strategy: str
    model: str | None
    conditions: str
    trajectory: str
    plane: str
    speed_m_s: float | None
    reached_m_s: float
    rms_m: float | None = None
    rms_estimate_m: float | None = None
    rms_axes_m: tuple[float, float, float] | None = None
    max_m: float | None = None
    active_share: float | None = None
    gp_rms_m: float | None = None
    event_s: float | None = None
    recovery_s: float | None = None
    guard: dict[str, int] = {}
    error: str | None = None


Row = TypeVar("Row", bound=FlightRow)


def flight_row(course: Course, contender: Contender, result: Result) -> FlightRow:
    """The row of a flight."""
    row = FlightRow(
        vehicle=contender.vehicle,
        strategy=contender.strategy,
        model=None if contender.model is None else contender.model.name,
        conditions=result.scenario.conditions,
        trajectory=course.drawing,
        plane=course.plane,
        speed_m_s=course.speed_m_s,
        reached_m_s=course.reached_m_s,
    )
    if isinstance(result, Failed):
        return row.model_copy(update={"error": result.reason})
    north, east, down = result.accuracy.rms_axes_m.tolist()
    return row.model_copy(
        update={
            "rms_m": result.accuracy.rms_m,
            "rms_estimate_m": result.estimated_accuracy.rms_m,
            "rms_axes_m": (north, east, down),
            "max_m": result.accuracy.max_m,
            "active_share": result.active_share,
            "event_s": result.event_s,
            "recovery_s": result.recovery_s,
            "guard": {str(clip): count for clip, count in result.clips.items()},
        }
    )


def beside_gp(rows: Iterable[Row]) -> list[Row]:
    """The rows, each with the RMS error of `gp` where that flew the same."""
    rows = list(rows)
    of_gp = {_same_flight(row): row.rms_m for row in rows if row.strategy == Strategy.GP}
    return [row.model_copy(update={"gp_rms_m": of_gp.get(_same_flight(row))}) for row in rows]


def _same_flight(row: FlightRow) -> tuple[object, ...]:
    return row.vehicle, row.conditions, row.trajectory, row.plane, row.speed_m_s
