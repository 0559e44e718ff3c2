"""The instants at which a trajectory is looked at, to see whether it leaves a fence or comes near a place."""

import numpy as np

from companion.arrays import Times
from companion.trajectory.trajectory import Trajectory

LOOK_EVERY_S = 0.02


def instants(trajectory: Trajectory) -> Times:
    """From its beginning on `LOOK_EVERY_S` apart, and its end (s)."""
    return np.append(np.arange(0.0, trajectory.duration_s, LOOK_EVERY_S), trajectory.duration_s)
