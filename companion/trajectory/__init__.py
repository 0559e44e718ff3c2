"""Trajectories as functions of time: readers, timing, placement."""
