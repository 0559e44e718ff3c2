"""How far the estimate is from where GPS has the vehicle: GLOBAL_POSITION_INT against GPS_RAW_INT.

An estimator that goes astray with its position, away from a receiver that it should have followed, tells
of it nowhere else: its test ratios are of the measurements that it still uses.
"""

import math
from collections import deque

import numpy as np

from companion.arrays import Vec3
from companion.geodesy import Place, ned_from_geodetic
from companion.link.dialect import mavlink

_MEAN_OF_S = 1.0
_LATE_S = 0.3
"""By so much a fix may be older than the estimate that it is compared with."""
_KEPT_S = 1.0
"""An older estimate is not compared with."""
_GOOD_M = 1.0
"""A receiver that claims less than this for its accuracy is not taken at its word."""
_E_7 = 1e-7


class GpsComparison:
    """Compares each fix with the newest estimate, horizontally; the mean over a second counts."""

    def __init__(self) -> None:
        self._estimate: tuple[float, Place, Vec3] | None = None
        self._apart: deque[tuple[float, Vec3]] = deque()

    def estimate(self, message: mavlink.MAVLink_global_position_int_message, now_s: float) -> None:
        """Take in what the vehicle believes, come at `now_s` (companion clock, s)."""
        velocity = np.array([message.vx, message.vy, message.vz]) * 1e-2
        self._estimate = now_s, Place(message.lat * _E_7, message.lon * _E_7, 0.0), velocity

    def fix(self, message: mavlink.MAVLink_gps_raw_int_message, now_s: float) -> float:
        """How far they are apart (m), now that a fix has come at `now_s` (companion clock, s).

        As of a receiver that is accurate to a metre: of one that claims three (h_acc), it is a third. What
        a fix may lag behind at the vehicle's speed is left out. NaN where there is nothing to compare.
        """
        is_fix = message.fix_type >= mavlink.GPS_FIX_TYPE_3D_FIX
        if self._estimate is None or now_s > self._estimate[0] + _KEPT_S or not is_fix:
            self._apart.clear()
            return math.nan
        then_s, place, velocity = self._estimate
        offset = ned_from_geodetic(Place(message.lat * _E_7, message.lon * _E_7, 0.0), place)
        self._apart.append((now_s, offset - velocity * (now_s - then_s)))
        while self._apart[0][0] < now_s - _MEAN_OF_S:
            self._apart.popleft()
        north, east, _ = np.mean([apart for _, apart in self._apart], axis=0)
        excess_m = math.hypot(north, east) - _LATE_S * math.hypot(velocity[0], velocity[1])
        return max(0.0, excess_m) / max(_GOOD_M, message.h_acc * 1e-3)
