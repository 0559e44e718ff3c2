"""PX4's offboard setpoints: the newest, how old it is, and whether it asks to leave the ground."""

import math
from dataclasses import replace

import numpy as np

from sitl.arrays import Vec3
from sitl.firmware.interface import Setpoint


class Offboard:
    """The stream of setpoints.

    Attributes:
        setpoint: the newest.
    """

    def __init__(self) -> None:
        self.setpoint = Setpoint()
        self._heard_s = -math.inf

    def take(self, setpoint: Setpoint, time_s: float) -> None:
        """A setpoint arrived at this time (s); one that is all switched off is none."""
        channels = (setpoint.position, setpoint.velocity, setpoint.acceleration)
        if any(np.isfinite(channel).any() for channel in channels):
            self.setpoint = setpoint
            self._heard_s = time_s

    def age_s(self, time_s: float) -> float:
        """Since the newest arrived."""
        return time_s - self._heard_s

    def jump(self, position: Vec3, velocity: Vec3) -> None:
        """The estimate jumped by this (m, m/s), and what was sent before along with it."""
        before = self.setpoint
        self.setpoint = replace(
            before, position=before.position + position, velocity=before.velocity + velocity
        )

    def climbs_from(self, down: float) -> bool:
        """Whether it asks to rise from a height, NED (m)."""
        wanted = self.setpoint
        return bool(wanted.position[2] < down or wanted.velocity[2] < 0.0 or wanted.acceleration[2] < 0.0)
