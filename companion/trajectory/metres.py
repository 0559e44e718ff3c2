"""From positions in metres with their times to a trajectory."""

import numpy as np

from companion.arrays import Times, Vec3s
from companion.errors import InputError
from companion.trajectory.limits import Limits, peaks_of, stretches
from companion.trajectory.smoothing import evenly_spaced, smooth
from companion.trajectory.timing import Path, along, as_fast_as_allowed, slowed_to_allowed, window_to_reach
from companion.trajectory.trajectory import Trajectory

TOLERANCES_M = (0.001, 0.003, 0.01, 0.03)
"""How far smoothing may move the line (m): the first with which the limits hold, or else the last."""


def timed_trajectory(name: str, times_s: Times, positions: Vec3s, limits: Limits) -> Trajectory:
    """The motion through `positions` (m, NED) at `times_s` (s), as given where the limits allow it.

    Between positions it is straight, and corners are rounded as far as the limits need it. What is too
    fast even so is slowed in proportion. A speed in `limits` becomes the peak speed unless another limit
    binds first. Where the motion begins or ends without rest it is eased, which adds to its time.

    Raises:
        InputError: the positions are all the same, or the motion takes too long to fly.
    """
    if np.ptp(positions, axis=0).max() < TOLERANCES_M[0]:
        raise InputError("all positions are the same; a trajectory needs at least two different ones")
    allowed = limits.peaks(usual_speed_m_s=np.inf)
    even = evenly_spaced(positions, times_s)
    for tolerance_m in TOLERANCES_M:
        path = Path(smooth(even, tolerance_m), end=float(times_s[-1] - times_s[0]))
        rate = 1.0 if limits.speed_m_s is None else limits.speed_m_s / path.speed_at(path.parameter).max()
        ends_m_s = rate * path.speed_at(path.parameter[[0, -1]]).max()
        pace = np.full(len(even), rate)
        trajectory = along(name, path, pace, window_to_reach(ends_m_s, allowed))
        if max(stretches(peaks_of(trajectory), allowed).values()) <= 1.0:
            break
    if limits.speed_m_s is None:
        return slowed_to_allowed(trajectory, allowed)
    return as_fast_as_allowed(trajectory, allowed)
