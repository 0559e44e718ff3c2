"""Array types with their shapes, as used in signatures throughout the simulator."""

from typing import TypeAlias

import numpy as np
from jaxtyping import Float

Array: TypeAlias = np.ndarray[tuple[int, ...], np.dtype[np.float64]]
Vec3: TypeAlias = Float[Array, "3"]
Quaternion: TypeAlias = Float[Array, "4"]
"""Unit quaternion w, x, y, z that turns body (FRD) vectors into NED."""
