"""What to fly, how, and what came of it."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from enum import StrEnum

from companion.flight.guard import Clip, GuardLimits
from companion.flight.heading import YawMode
from companion.flight.online_correction import OnlineCorrection
from companion.flight.strategies import ReferenceLaw, position_velocity
from companion.flight.supervision import Supervision
from companion.flight.vehicle_fence import NO_FENCE, VehicleFence
from companion.recording.metrics import TrackingAccuracy
from companion.recording.series import Recording
from companion.trajectory.trajectory import Trajectory


class After(StrEnum):
    """How a vehicle is handed back after its flight, by the names that the command takes."""

    HOLD = "hold"
    LAND = "land"
    RETURN = "return"


@dataclass(frozen=True)
class FlightPlan:
    """What to fly, and how.

    Attributes:
        trajectory: NED relative to the takeoff point (m).
        law: how u1 is made.
        correction: the online module, or None.
        supervision: how much of it and of a network is flown, or None: all.
        period_s: between two setpoints (s).
        limits: of the guard.
        vehicle_fence: the vehicle's own, relative to the takeoff point.
        settle_s: least time at rest at the start, the strategy already active (s).
        takeoff_altitude_m: where a vehicle on the ground is first sent, above its takeoff point (m).
        after: how the vehicle is handed back.
        yaw: where the nose points.
        resume: take over a vehicle that is in the air, where it is, and go on at the nearest point.
        cut_off: what the last flight of this vehicle was called, if nobody knows how it ended: a vehicle that
            it left in the air is not taken over but to resume.
    """

    trajectory: Trajectory
    law: ReferenceLaw = position_velocity
    correction: OnlineCorrection | None = None
    supervision: Supervision | None = None
    period_s: float = 0.02
    limits: GuardLimits = field(default_factory=GuardLimits)
    vehicle_fence: VehicleFence = NO_FENCE
    settle_s: float = 3.0
    takeoff_altitude_m: float = 2.5
    after: After = After.HOLD
    yaw: YawMode = YawMode.HOLD
    resume: bool = False
    cut_off: str = ""

    @property
    def is_plain(self) -> bool:
        """Whether its strategy is the plain one: nothing learned, nothing ahead of its time."""
        return self.law is position_velocity and self.correction is None


@dataclass(frozen=True)
class FlightOutcome:
    """What came of a flight.

    Attributes:
        accuracy: against the vehicle's own estimate, which is all that a companion can know.
        trajectory: what was to be flown, NED of the vehicle's origin (m).
        start_s: when it began, or would have, where it was resumed (companion clock, s).
        clips: how often the guard changed what.
        recording: what the recorder still has of it.
    """

    accuracy: TrackingAccuracy
    trajectory: Trajectory
    start_s: float
    clips: Mapping[Clip, int]
    recording: Recording
