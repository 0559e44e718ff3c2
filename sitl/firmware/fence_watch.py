"""Notices when a vehicle leaves its fence, and when it is back."""

from sitl.arrays import Vec3
from sitl.firmware.interface import FenceStatus
from sitl.plan.fence import Limits

_CHECK_EVERY_S = 0.2
"""PX4's GEOFENCE_CHECK_INTERVAL_US."""


class FenceWatch:
    """Keeps the state of a fence; what follows from a breach is up to the autopilot."""

    def __init__(self) -> None:
        self.status = FenceStatus()
        self._checked_s = -_CHECK_EVERY_S

    def update(self, limits: Limits | None, position: Vec3, home: Vec3, time_s: float) -> bool:
        """Whether a limit has been broken since the last look; `limits` is None while the fence is off."""
        if time_s - self._checked_s < _CHECK_EVERY_S:
            return False
        self._checked_s = time_s
        before = self.status
        breach = limits.broken_at(position, home) if limits else ""
        new = bool(breach) and not before.breach
        self.status = FenceStatus(
            enabled=limits is not None,
            breach=breach,
            count=before.count + new,
            since_s=time_s if new else before.since_s,
        )
        return new
