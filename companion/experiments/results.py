"""RMS errors of several flights side by side: trajectory × strategy, with what was gained on `baseline`."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TypeAlias

from rich.box import SIMPLE_HEAD
from rich.table import Table
from rich.text import Text

RmsErrors: TypeAlias = Mapping[tuple[str, str], float]
"""RMS error (m) of each flight, by the names of its trajectory and its strategy."""

BASELINE = "baseline"


@dataclass(frozen=True)
class Cell:
    """One flight, or the mean over a strategy's flights.

    Attributes:
        rms_m: RMS error (m).
        reduction: 1 − rms / baseline's rms on the same trajectory; None for the baseline or without one.
    """

    rms_m: float
    reduction: float | None

    @property
    def change(self) -> str:
        """The change against the baseline, as in tables: `−45 %`, or nothing."""
        return "" if self.reduction is None else f"{-100.0 * self.reduction:+.0f} %".replace("-", "−")


def trajectories_of(rms_m: RmsErrors) -> list[str]:
    """Names of the trajectories flown, in the order of their first flights."""
    return list(dict.fromkeys(trajectory for trajectory, _ in rms_m))


def strategies_of(rms_m: RmsErrors) -> list[str]:
    """Names of the strategies flown, in the order of their first flights."""
    return list(dict.fromkeys(strategy for _, strategy in rms_m))


def cell(rms_m: RmsErrors, trajectory: str, strategy: str) -> Cell | None:
    """The flight of `trajectory` with `strategy`; None when it was not flown."""
    rms = rms_m.get((trajectory, strategy))
    if rms is None:
        return None
    baseline = rms_m.get((trajectory, BASELINE))
    return Cell(rms, None if strategy == BASELINE or not baseline else 1.0 - rms / baseline)


def mean_cell(rms_m: RmsErrors, strategy: str) -> Cell:
    """Mean over the trajectories that `strategy` flew: of the RMS errors, and of the reductions."""
    cells = [each for name in trajectories_of(rms_m) if (each := cell(rms_m, name, strategy)) is not None]
    reductions = [each.reduction for each in cells if each.reduction is not None]
    return Cell(
        rms_m=sum(each.rms_m for each in cells) / len(cells),
        reduction=sum(reductions) / len(reductions) if reductions else None,
    )


def results_rows(rms_m: RmsErrors) -> list[tuple[str, list[Cell | None]]]:
    """A row for each trajectory and, where there are several, one of means; a cell for each strategy."""
    trajectories, strategies = trajectories_of(rms_m), strategies_of(rms_m)
    rows = [(name, [cell(rms_m, name, strategy) for strategy in strategies]) for name in trajectories]
    if len(trajectories) > 1:
        rows.append(("mean", [mean_cell(rms_m, strategy) for strategy in strategies]))
    return rows


def results_table(rms_m: RmsErrors) -> Table:
    """The table for a terminal."""
    table = Table(box=SIMPLE_HEAD, caption="RMS error in metres; beneath, its change against the baseline")
    table.add_column("trajectory")
    for strategy in strategies_of(rms_m):
        table.add_column(strategy, justify="right")
    for name, cells in results_rows(rms_m):
        table.add_row(Text(name), *map(_text, cells))
    return table


def _text(cell: Cell | None) -> Text:
    return Text("–") if cell is None else Text(f"{cell.rms_m:.3f}\n{cell.change}")
