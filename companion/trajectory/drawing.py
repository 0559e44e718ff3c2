"""From a drawing, a line by hand in any unit, with or without times, to a trajectory."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from companion.arrays import Array
from companion.errors import InputError
from companion.trajectory.limits import Limits
from companion.trajectory.placement import Placement
from companion.trajectory.smoothing import evenly_spaced, lengths, smooth
from companion.trajectory.timing import (
    Path,
    along,
    as_fast_as_allowed,
    pace_by_bends,
    steady_pace,
    window_to_reach,
)
from companion.trajectory.trajectory import Trajectory

SPEED_M_S = 1.2
"""Peak speed along a drawing where none is asked for."""

TOLERANCE = 0.01
"""How far smoothing may move the line, as a share of the drawing's size."""


@dataclass(frozen=True, eq=False)
class Drawing:
    """A line as it was drawn.

    Attributes:
        name: what to call it.
        points: x to the right, y upwards, in any unit.
        times: when each point was drawn, rising, in any unit; None where that is not known.
    """

    name: str
    points: Float[Array, "n 2"]
    times: Float[Array, " n"] | None = None


def drawing_trajectory(drawing: Drawing, placement: Placement, limits: Limits) -> Trajectory:
    """The drawing smoothed, placed, and flown from rest to rest as fast as the limits allow.

    Where the drawing has times they are kept in proportion, but for an eased start and end. Otherwise
    every bend has the speed that it allows.

    Raises:
        InputError: fewer than two different points, or too long to fly.
    """
    allowed = limits.peaks(usual_speed_m_s=SPEED_M_S)
    points = _to_unit_size(drawing)
    if drawing.times is None:
        line = placement.place(_smoothed(points, lengths(points)))
        path = Path(line, end=float(lengths(line)[-1]))
        pace = pace_by_bends(path, allowed)
    else:
        path = Path(placement.place(_smoothed(points, drawing.times)), end=1.0)
        pace = steady_pace(path, allowed)
    top_speed_m_s = float((pace * path.speed_at(path.parameter)).max())
    window_s = window_to_reach(top_speed_m_s, allowed)
    return as_fast_as_allowed(along(drawing.name, path, pace, window_s), allowed)


def _to_unit_size(drawing: Drawing) -> Float[Array, "n 2"]:
    lowest = drawing.points.min(axis=0)
    size = (drawing.points.max(axis=0) - lowest).max()
    if size <= 1e-9 * np.abs(drawing.points).max():
        raise InputError("all points are the same; a drawing needs at least two different ones")
    return np.asarray((drawing.points - lowest) / size)


def _smoothed(points: Float[Array, "n 2"], parameter: Float[Array, " n"]) -> Float[Array, "m 2"]:
    return smooth(evenly_spaced(points, parameter), TOLERANCE)
