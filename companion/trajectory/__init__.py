"""Trajectories as functions of time: reading, placing, smoothing and timing them."""

from companion.trajectory.limits import Limits, Peaks
from companion.trajectory.placement import Placement
from companion.trajectory.readers import read_trajectory
from companion.trajectory.summary import Summary, summarise
from companion.trajectory.training import training_sinusoids
from companion.trajectory.trajectory import Sample, Samples, Trajectory

__all__ = [
    "Limits",
    "Peaks",
    "Placement",
    "Sample",
    "Samples",
    "Summary",
    "Trajectory",
    "read_trajectory",
    "summarise",
    "training_sinusoids",
]
