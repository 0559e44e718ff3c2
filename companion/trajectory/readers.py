"""Reading a trajectory from a file; the names of its columns tell what it holds.

| columns      | what                                                                      |
|--------------|---------------------------------------------------------------------------|
| `t, n, e, d` | seconds; metres north, east and down of the vehicle's local origin        |
| `t, x, y, z` | seconds; metres north, east and up                                        |
| `t, x, y`    | a drawing: x to the right, y upwards, in any unit; times in any unit      |
| `x, y`       | a drawing without times                                                   |

Without a header, two columns are `x, y`, and three are `t, x, y`.
"""

from pathlib import Path

import numpy as np

from companion.arrays import Times
from companion.errors import InputError
from companion.trajectory.drawing import Drawing, drawing_trajectory
from companion.trajectory.limits import Limits
from companion.trajectory.metres import timed_trajectory
from companion.trajectory.placement import Placement
from companion.trajectory.table import Table, read_table
from companion.trajectory.trajectory import Trajectory

_FORMATS = (("t", "n", "e", "d"), ("t", "x", "y", "z"), ("t", "x", "y"), ("x", "y"))
_HEADERLESS = {2: ("x", "y"), 3: ("t", "x", "y")}
_EXPECTED = " or ".join(",".join(columns) for columns in _FORMATS)


def read_trajectory(path: Path, placement: Placement, limits: Limits) -> Trajectory:
    """The trajectory in a CSV file, named after it.

    A drawing is smoothed, placed by `placement` and timed to the limits. A file in metres has its place,
    and its times are kept as far as the limits allow.

    Raises:
        InputError: the file cannot be read as a trajectory; names the file and, where there is one, the line.
    """
    table = read_table(path)
    columns = _columns(path, table)
    if len(table.lines) < 2:
        raise InputError(
            f"{path}:{max(table.lines, default=table.first_line)}: a trajectory needs at least two points"
        )
    values = dict(zip(columns, table.values.T, strict=True))
    if "t" in values:
        _require_rising(path, table, values["t"])
    try:
        if set(columns) == {"t", "n", "e", "d"}:
            positions = np.stack([values["n"], values["e"], values["d"]], axis=1)
            return timed_trajectory(path.stem, values["t"], positions, limits)
        if set(columns) == {"t", "x", "y", "z"}:
            positions = np.stack([values["x"], values["y"], -values["z"]], axis=1)
            return timed_trajectory(path.stem, values["t"], positions, limits)
        points = np.stack([values["x"], values["y"]], axis=1)
        return drawing_trajectory(Drawing(path.stem, points, values.get("t")), placement, limits)
    except InputError as error:
        raise InputError(f"{path}: {error}") from error


def _columns(path: Path, table: Table) -> tuple[str, ...]:
    """The names of the columns, in the order of the file."""
    if table.columns is None:
        width = table.values.shape[1]
        if width not in _HEADERLESS:
            raise InputError(
                f"{path}:{table.first_line}: {width} columns without names; start the file with {_EXPECTED}"
            )
        return _HEADERLESS[width]
    if set(table.columns) not in map(set, _FORMATS) or len(set(table.columns)) < len(table.columns):
        names = ",".join(table.columns)[:60]
        raise InputError(f"{path}:{table.first_line}: columns are {names}; expected {_EXPECTED}")
    return table.columns


def _require_rising(path: Path, table: Table, times: Times) -> None:
    falls = np.flatnonzero(np.diff(times) <= 0.0)
    if len(falls):
        row = falls[0] + 1
        what = "repeats" if times[row] == times[row - 1] else "goes back from"
        raise InputError(
            f"{path}:{table.lines[row]}: time {times[row]:g} {what} {times[row - 1]:g}; times must rise"
        )
