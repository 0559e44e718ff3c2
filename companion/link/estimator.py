"""What a vehicle tells of its estimator's health: ESTIMATOR_STATUS (PX4), EKF_STATUS_REPORT (ArduPilot)."""

import math
from dataclasses import dataclass

from companion.link.dialect import mavlink

_ESTIMATES = (
    # The low bits mean the same in both.
    ("attitude", mavlink.ESTIMATOR_ATTITUDE),
    ("horizontal velocity", mavlink.ESTIMATOR_VELOCITY_HORIZ),
    ("vertical velocity", mavlink.ESTIMATOR_VELOCITY_VERT),
    ("horizontal position", mavlink.ESTIMATOR_POS_HORIZ_REL | mavlink.ESTIMATOR_POS_HORIZ_ABS),
    ("height", mavlink.ESTIMATOR_POS_VERT_ABS | mavlink.ESTIMATOR_POS_VERT_AGL),
)


@dataclass(frozen=True, slots=True)
class Estimator:
    """Its own account of itself.

    Attributes:
        missing: which estimates there are not, in words.
        gps_glitch: whether GPS contradicts the rest.
        worst_ratio: largest innovation test ratio; from 1 on a measurement is rejected.
    """

    missing: tuple[str, ...] = ()
    gps_glitch: bool = False
    worst_ratio: float = 0.0


def of_px4(message: mavlink.MAVLink_estimator_status_message) -> Estimator:
    """From PX4's message."""
    ratios = (message.vel_ratio, message.pos_horiz_ratio, message.pos_vert_ratio, message.mag_ratio)
    glitch = bool(message.flags & mavlink.ESTIMATOR_GPS_GLITCH)
    return Estimator(_missing(message.flags), glitch, _worst(ratios))


def of_ardupilot(message: mavlink.MAVLink_ekf_status_report_message) -> Estimator:
    """From ArduPilot's."""
    ratios = (
        message.velocity_variance,
        message.pos_horiz_variance,
        message.pos_vert_variance,
        message.compass_variance,
    )
    glitch = bool(message.flags & mavlink.EKF_GPS_GLITCHING)
    return Estimator(_missing(message.flags), glitch, _worst(ratios))


def _missing(flags: int) -> tuple[str, ...]:
    return tuple(name for name, bits in _ESTIMATES if not flags & bits)


def _worst(ratios: tuple[float, ...]) -> float:
    return max((ratio for ratio in ratios if math.isfinite(ratio)), default=0.0)
