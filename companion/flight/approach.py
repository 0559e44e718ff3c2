"""Short trajectories that bring the vehicle to where a longer one begins."""

import numpy as np

from companion.arrays import Vec3
from companion.trajectory.trajectory import Trajectory, quintic_through

APPROACH_SPEED_M_S = 1.0
_PEAK_OVER_MEAN_SPEED = 1.875  # of a quintic from rest to rest
_SHORTEST_S = 1.0


def rest_at(position: Vec3, name: str = "hold") -> Trajectory:
    """Staying at `position` (NED, m)."""
    return rest_to_rest(position, position, name)


def rest_to_rest(start: Vec3, end: Vec3, name: str = "approach") -> Trajectory:
    """A straight line (NED, m) from rest to rest, at most `APPROACH_SPEED_M_S` fast, without jolts."""
    distance_m = float(np.linalg.norm(end - start))
    duration_s = max(_SHORTEST_S, _PEAK_OVER_MEAN_SPEED * distance_m / APPROACH_SPEED_M_S)
    still = np.zeros((2, 3))
    return quintic_through(name, duration_s, np.stack([start, end]), still, still)
