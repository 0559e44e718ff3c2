"""Where in the world a drawing is flown: its size, plane, heading and place."""

from dataclasses import dataclass
from typing import Literal

import numpy as np
from jaxtyping import Float

from companion.arrays import Array, Vec3s
from companion.errors import InputError

LOWEST_M = 1.5
"""Least height of a drawing above takeoff (m)."""


@dataclass(frozen=True)
class Placement:
    """How the axes of a drawing, x to its right and y upwards, become north, east and down.

    Attributes:
        size_m: the longest side of the drawing's bounding box (m).
        plane: "xz" stands upright: x along the heading, y up. "xy" lies level: x along the heading, y to
            the right of it (at heading 0, x is north and y is east).
        origin: north and east (m) of the centre of the bounding box.
        heading_rad: direction of the drawing's x axis, clockwise from north.
        altitude_m: height of the lowest point above takeoff (m), at least `LOWEST_M`.
        flip_y: whether y points down in the file, as on screens and in SVG.

    Raises:
        InputError: a value is out of range.
    """

    size_m: float = 3.0
    plane: Literal["xz", "xy"] = "xz"
    origin: tuple[float, float] = (0.0, 0.0)
    heading_rad: float = 0.0
    altitude_m: float = LOWEST_M
    flip_y: bool = False

    def __post_init__(self) -> None:
        if not 0.0 < self.size_m < np.inf:
            raise InputError(f"size is {self.size_m} m: give a positive number of metres")
        if self.plane not in ("xz", "xy"):
            raise InputError(f'plane is "{self.plane}": give xz (upright) or xy (level)')
        if not LOWEST_M <= self.altitude_m < np.inf:
            raise InputError(f"altitude is {self.altitude_m} m: give at least {LOWEST_M} m above takeoff")
        if not np.isfinite([*self.origin, self.heading_rad]).all():
            raise InputError(f"origin {self.origin} and heading {self.heading_rad} must be finite numbers")

    def place(self, points: Float[Array, "n 2"]) -> Vec3s:
        """Points of a drawing, in any unit, as positions (m, NED)."""
        lowest, highest = points.min(axis=0), points.max(axis=0)
        metres = (points - 0.5 * (lowest + highest)) * (self.size_m / (highest - lowest).max())
        x, y = metres[:, 0], -metres[:, 1] if self.flip_y else metres[:, 1]
        forward = np.array([np.cos(self.heading_rad), np.sin(self.heading_rad)])
        right = np.array([-forward[1], forward[0]])
        positions = np.empty((len(points), 3))
        if self.plane == "xz":
            positions[:, :2] = self.origin + np.outer(x, forward)
            positions[:, 2] = y.min() - y - self.altitude_m
        else:
            positions[:, :2] = self.origin + np.outer(x, forward) + np.outer(y, right)
            positions[:, 2] = -self.altitude_m
        return positions
