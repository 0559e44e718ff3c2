"""A flight as tables and pictures show it."""

from dataclasses import dataclass

from companion.arrays import Times, Vec3s


@dataclass(frozen=True, eq=False)
class Flight:
    """Where a vehicle was to be and where it was, at the instants of its states along one trajectory.

    Attributes:
        trajectory_name: what was to be flown.
        strategy: with which strategy.
        time_s: time of each state (s).
        desired: the trajectory at those times (NED, m).
        flown: the position at those times (NED, m).
        rms_m: root mean square of the distance between them (m).
        begun_s: when the trajectory began, or would have, where it was joined later (s); None: `time_s[0]`.
    """

    trajectory_name: str
    strategy: str
    time_s: Times
    desired: Vec3s
    flown: Vec3s
    rms_m: float
    begun_s: float | None = None

    @property
    def along_s(self) -> Times:
        """Time of each state since the trajectory began (s)."""
        along: Times = self.time_s - (self.time_s[0] if self.begun_s is None else self.begun_s)
        return along
