"""Short trajectories that bring the vehicle to where a longer one begins, or onto it half-way."""

import numpy as np

from companion.arrays import Vec3
from companion.flight.instants import instants
from companion.trajectory.trajectory import Trajectory, quintic_through

APPROACH_SPEED_M_S = 1.0
_PEAK_OVER_MEAN_SPEED = 1.875  # of a quintic from rest to rest
_SHORTEST_S = 1.0
_SHORTEST_JOINING_S = 2.0


def rest_at(position: Vec3, name: str = "hold") -> Trajectory:
    """Staying at `position` (NED, m)."""
    return rest_to_rest(position, position, name)


def rest_to_rest(start: Vec3, end: Vec3, name: str = "approach") -> Trajectory:
    """A straight line (NED, m) from rest to rest, at most `APPROACH_SPEED_M_S` fast, without jolts."""
    distance_m = float(np.linalg.norm(end - start))
    duration_s = max(_SHORTEST_S, _PEAK_OVER_MEAN_SPEED * distance_m / APPROACH_SPEED_M_S)
    still = np.zeros((2, 3))
    return quintic_through(name, duration_s, np.stack([start, end]), still, still)


def joining(position: Vec3, trajectory: Trajectory) -> tuple[Trajectory, float]:
    """From rest at `position` (NED, m) onto the moving trajectory, near where it comes nearest.

    Returns:
        The way there, which ends with the trajectory's own velocity and acceleration, and the time on the
        trajectory at which it does (s).
    """
    times_s = instants(trajectory)
    distances_m = np.linalg.norm(trajectory.sample(times_s).position - position, axis=1)
    nearest = int(distances_m.argmin())
    at_ease_s = _PEAK_OVER_MEAN_SPEED * float(distances_m[nearest]) / APPROACH_SPEED_M_S
    duration_s = max(_SHORTEST_JOINING_S, at_ease_s)
    # Speeding up evenly from rest covers half of what the trajectory does meanwhile.
    joins_s = min(times_s[nearest] + 0.5 * duration_s, trajectory.duration_s)
    start, end = rest_at(position).at(0.0), trajectory.at(joins_s)
    way = quintic_through("joining", duration_s, *(np.stack(pair) for pair in zip(start, end, strict=True)))
    return way, float(joins_s)
