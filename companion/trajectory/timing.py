"""From a path to a trajectory: how fast to go along it, from rest to rest, within the limits.

A path is a position as a function of a parameter: the pen's own time, or the length of the line. A *pace* is
how fast that parameter grows. Any pace is averaged over a window of time, with rest before the start and
after the end: that eases both ends, and every change of pace. A stretch of the whole then meets the limits.
"""

from dataclasses import replace

import numpy as np
from jaxtyping import Float
from scipy.interpolate import BSpline, make_interp_spline

from companion.arrays import Array, Vec3s
from companion.errors import InputError
from companion.trajectory.limits import Peaks, peaks_of, stretches
from companion.trajectory.trajectory import Trajectory, quintic_through

LONGEST_S = 1800.0
_SHORTEST_WINDOW_S = 0.4
_KNOTS_PER_WINDOW = 16
_FOR_BENDS = 0.5
"""Share of acceleration and jerk for the bends, where a pace is made up; changes of pace get the rest."""


class Path:
    """A smooth line through points (m, NED) that belong to an evenly spaced parameter from 0 to `end`."""

    def __init__(self, points: Vec3s, end: float) -> None:
        self.parameter = np.linspace(0.0, end, len(points))
        self._spline: BSpline = make_interp_spline(self.parameter, points, k=5)

    def derivative(self, parameter: Float[Array, " n"], order: int) -> Vec3s:
        """The derivative of that order by the parameter."""
        return np.asarray(self._spline(parameter, nu=order))

    def speed_at(self, parameter: Float[Array, " n"]) -> Float[Array, " n"]:
        """How far the line goes per unit of the parameter (m)."""
        return np.asarray(np.linalg.norm(self.derivative(parameter, 1), axis=1))


def steady_pace(path: Path, allowed: Peaks) -> Float[Array, " n"]:
    """The one pace that keeps all of the path within what is allowed: natural timing in proportion."""
    return np.full(len(path.parameter), _pace_limits(path, allowed).min())


def pace_by_bends(path: Path, allowed: Peaks) -> Float[Array, " n"]:
    """As fast as each bend allows, with constant acceleration between bends.

    For a path whose parameter is its length (m), or nearly.
    """
    for_bends = replace(
        allowed,
        acceleration_m_s2=_FOR_BENDS * allowed.acceleration_m_s2,
        jerk_m_s3=_FOR_BENDS * allowed.jerk_m_s3,
        vertical_acceleration_m_s2=_FOR_BENDS * allowed.vertical_acceleration_m_s2,
    )
    # Along the line, the square of the speed grows or falls by at most twice the acceleration.
    rise = 2.0 * (1.0 - _FOR_BENDS) * allowed.acceleration_m_s2 * path.parameter
    squared = _pace_limits(path, for_bends) ** 2
    squared = np.minimum.accumulate(squared - rise) + rise
    squared = np.minimum.accumulate((squared + rise)[::-1])[::-1] - rise
    return np.sqrt(squared)


def window_to_reach(speed_m_s: float, allowed: Peaks) -> float:
    """The window of time (s) over which a step to `speed_m_s` is averaged within acceleration and jerk.

    Under a Hann window of length w, a step to speed v takes an acceleration of 2 v / w and a jerk of
    2π v / w².
    """
    for_acceleration = 2.0 * speed_m_s / allowed.acceleration_m_s2
    for_jerk = np.sqrt(2.0 * np.pi * speed_m_s / allowed.jerk_m_s3)
    return max(_SHORTEST_WINDOW_S, 1.05 * for_acceleration, 1.05 * float(for_jerk))


def along(name: str, path: Path, pace: Float[Array, " n"], window_s: float) -> Trajectory:
    """The trajectory along `path` at `pace` (a second, at each parameter), averaged over `window_s` (s).

    Raises:
        InputError: it would take longer than `LONGEST_S`.
    """
    seconds = np.diff(path.parameter) * 0.5 * (1.0 / pace[1:] + 1.0 / pace[:-1])
    arrival_s = np.concatenate([[0.0], np.cumsum(seconds)])
    duration_s = arrival_s[-1] + window_s
    _refuse_long(duration_s)
    # Each knot averages the window up to it, so that the end is reached one window late.
    step_s = window_s / _KNOTS_PER_WINDOW
    segments = int(np.ceil(duration_s / step_s))
    instants = np.arange(-_KNOTS_PER_WINDOW, segments + 1) * step_s
    window = np.hanning(_KNOTS_PER_WINDOW + 1)
    reached = np.convolve(np.interp(instants, arrival_s, path.parameter), window / window.sum(), mode="valid")
    at_rest = [(1, 0.0), (2, 0.0)]
    times = step_s * np.arange(segments + 1)
    progress = make_interp_spline(times, reached, k=5, bc_type=(at_rest, at_rest))  # type: ignore[arg-type]
    pace, change = progress(times, nu=1)[:, None], progress(times, nu=2)[:, None]
    position, slope, bend = (path.derivative(reached, order) for order in range(3))
    return quintic_through(name, step_s, position, slope * pace, bend * pace**2 + slope * change)


def as_fast_as_allowed(trajectory: Trajectory, allowed: Peaks) -> Trajectory:
    """The trajectory with its time stretched, or shortened, until the first limit binds.

    Raises:
        InputError: it would take longer than `LONGEST_S`.
    """
    return _stretched(trajectory, max(stretches(peaks_of(trajectory), allowed).values()))


def slowed_to_allowed(trajectory: Trajectory, allowed: Peaks) -> Trajectory:
    """The trajectory as it is where all limits hold, or else stretched until the last of them does.

    Raises:
        InputError: it would take longer than `LONGEST_S`.
    """
    return _stretched(trajectory, max(1.0, *stretches(peaks_of(trajectory), allowed).values()))


def _stretched(trajectory: Trajectory, factor: float) -> Trajectory:
    _refuse_long(factor * trajectory.duration_s)
    return trajectory.stretched(factor)


def _refuse_long(duration_s: float) -> None:
    if not duration_s <= LONGEST_S:
        raise InputError(
            f"it would take {duration_s:.0f} s within the limits, more than {LONGEST_S:.0f} s: "
            "make it shorter or smaller, or allow more speed"
        )


def _pace_limits(path: Path, allowed: Peaks) -> Float[Array, " n"]:
    """The highest steady pace at each parameter: speed is |r'| u̇, acceleration |r''| u̇², jerk |r'''| u̇³."""
    slope, bend, twist = (path.derivative(path.parameter, order) for order in (1, 2, 3))
    nothing = np.finfo(float).eps
    paces = np.stack(
        [
            allowed.speed_m_s / (nothing + np.linalg.norm(slope, axis=1)),
            np.sqrt(allowed.acceleration_m_s2 / (nothing + np.linalg.norm(bend, axis=1))),
            np.cbrt(allowed.jerk_m_s3 / (nothing + np.linalg.norm(twist, axis=1))),
            np.sqrt(allowed.vertical_acceleration_m_s2 / (nothing + np.abs(bend[:, 2]))),
            allowed.up_m_s / (nothing + np.maximum(-slope[:, 2], 0.0)),
            allowed.down_m_s / (nothing + np.maximum(slope[:, 2], 0.0)),
        ]
    )
    return np.asarray(paces.min(axis=0))
