"""How fast a trajectory may be, how fast it is, and the stretch of time that makes both equal."""

import math
from dataclasses import asdict, dataclass, replace

import numpy as np

from companion.arrays import Array
from companion.errors import InputError
from companion.trajectory.trajectory import Trajectory

SHARE = 0.8
"""How much of the vehicle's own limits a trajectory may use: what is left is for getting back onto it."""


@dataclass(frozen=True)
class Peaks:
    """The most of each that a trajectory has, or may have; norms but for climb and descent."""

    speed_m_s: float
    acceleration_m_s2: float
    jerk_m_s3: float
    up_m_s: float
    down_m_s: float
    vertical_acceleration_m_s2: float


@dataclass(frozen=True)
class Limits:
    """What a user allows a trajectory to ask of the vehicle.

    Attributes:
        speed_m_s: the peak speed asked for (m/s); None leaves it to the kind of file.
        acceleration_m_s2: norm (m/s²).
        jerk_m_s3: norm (m/s³).
        up_m_s: climb (m/s); by default from PX4's MPC_Z_VEL_MAX_UP, 3 m/s.
        down_m_s: descent (m/s); by default from PX4's MPC_Z_VEL_MAX_DN, 1.5 m/s.
        vertical_acceleration_m_s2: may be infinite (m/s²).

    Raises:
        InputError: a limit is not a positive number.
    """

    speed_m_s: float | None = None
    acceleration_m_s2: float = 4.0
    jerk_m_s3: float = 20.0
    up_m_s: float = SHARE * 3.0
    down_m_s: float = SHARE * 1.5
    vertical_acceleration_m_s2: float = math.inf

    def __post_init__(self) -> None:
        for name, limit in asdict(self).items():
            may_be_infinite = name == "vertical_acceleration_m_s2"
            if limit is not None and not (0.0 < limit < math.inf or (may_be_infinite and limit == math.inf)):
                raise InputError(f"limit {name} is {limit}: give a positive number")

    def peaks(self, usual_speed_m_s: float) -> Peaks:
        """The limits as peaks, with `usual_speed_m_s` (m/s) where no speed was asked for."""
        speed_m_s = usual_speed_m_s if self.speed_m_s is None else self.speed_m_s
        return Peaks(**asdict(self) | {"speed_m_s": speed_m_s})

    def within_vehicle(
        self,
        *,
        up_m_s: float,
        down_m_s: float,
        acceleration_m_s2: float = math.inf,
        vertical_acceleration_m_s2: float = math.inf,
    ) -> "Limits":
        """These limits with what the vehicle keeps to itself, less a reserve.

        The vehicle's vertical limits replace these; its horizontal acceleration can only lower theirs.
        """
        return replace(
            self,
            acceleration_m_s2=min(self.acceleration_m_s2, SHARE * acceleration_m_s2),
            up_m_s=SHARE * up_m_s,
            down_m_s=SHARE * down_m_s,
            vertical_acceleration_m_s2=SHARE * vertical_acceleration_m_s2,
        )


_ORDER = {
    "speed_m_s": 1,
    "acceleration_m_s2": 2,
    "jerk_m_s3": 3,
    "up_m_s": 1,
    "down_m_s": 1,
    "vertical_acceleration_m_s2": 2,
}
_INSTANTS = np.linspace(0.0, 1.0, 33)  # of each segment, both ends included: jerk may jump at knots


def peaks_of(trajectory: Trajectory) -> Peaks:
    """The peaks of the continuous trajectory, from 33 instants of every segment."""
    powers = _INSTANTS[:, None] ** np.arange(6)
    velocity, acceleration, jerk = (
        np.einsum("uk,mkd->mud", powers, trajectory.derivative(order)) for order in (1, 2, 3)
    )
    return Peaks(
        speed_m_s=_largest_norm(velocity),
        acceleration_m_s2=_largest_norm(acceleration),
        jerk_m_s3=_largest_norm(jerk),
        up_m_s=max(0.0, float(-velocity[..., 2].min())),
        down_m_s=max(0.0, float(velocity[..., 2].max())),
        vertical_acceleration_m_s2=float(np.abs(acceleration[..., 2]).max()),
    )


def stretches(peaks: Peaks, allowed: Peaks) -> dict[str, float]:
    """For each limit, the factor on time with which `peaks` would just reach it.

    When all takes c times as long, speeds are divided by c, accelerations by c², jerks by c³. The
    largest factor meets all limits; above 1, a limit is exceeded now.
    """
    return {
        name: float((getattr(peaks, name) / getattr(allowed, name)) ** (1.0 / order))
        for name, order in _ORDER.items()
    }


def _largest_norm(vectors: Array) -> float:
    return float(np.linalg.norm(vectors, axis=2).max())
