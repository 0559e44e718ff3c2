"""Companion software for multirotors: accurate tracking of arbitrary trajectories on the first attempt."""

__version__ = "0.1.0"
