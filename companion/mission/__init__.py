"""Missions: plan files, what of them can be tracked, and places on the Earth."""
