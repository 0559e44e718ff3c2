"""Array types with their shapes, as used in signatures throughout."""

from typing import TypeAlias

import numpy as np
from jaxtyping import Float

Array: TypeAlias = np.ndarray[tuple[int, ...], np.dtype[np.float64]]

Vec3: TypeAlias = Float[Array, "3"]
"""One vector: position, velocity, attitude (roll, pitch, yaw) or body rates."""

Vec3s: TypeAlias = Float[Array, "n 3"]
"""A series of such vectors, one a row."""

Times: TypeAlias = Float[Array, " n"]
"""Instants in seconds, rising."""
