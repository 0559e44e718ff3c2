"""One control step: desired motion, reference u1, online correction u2. No clock, no I/O."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, field

from companion.arrays import Vec3
from companion.flight.online_correction import OnlineCorrection, OnlineStep
from companion.flight.reference import Correction, Reference
from companion.flight.strategies import ReferenceLaw, position_velocity
from companion.flight.supervision import Supervision
from companion.learning.negative_transfer import Shares
from companion.state import VehicleState
from companion.trajectory.trajectory import Sample, Trajectory

PLAIN, CHOSEN = "plain", "chosen"


@dataclass(frozen=True, slots=True, eq=False)
class ControlStep:
    """What the tracker wants at one step, before the guard.

    Attributes:
        desired: the trajectory now.
        plain: the baseline's reference.
        u1: the strategy's reference.
        online: what the online module made of it, or None.
        u2: what is left of its correction; zero without an online module.
        shares: how much of network and correction is in them.
        remarks: what of that has changed, in words.
    """

    desired: Sample
    plain: Reference
    u1: Reference
    online: OnlineStep | None
    u2: Correction = field(default_factory=Correction)
    shares: Shares | None = None
    remarks: Sequence[str] = ()


class Tracker:
    """Follows one trajectory, which began or will begin at `start_s`, with one strategy.

    Before its beginning and after its end the trajectory rests, so the vehicle is held there the same way.
    """

    def __init__(
        self,
        trajectory: Trajectory,
        start_s: float,
        law: ReferenceLaw = position_velocity,
        correction: OnlineCorrection | None = None,
        supervision: Supervision | None = None,
    ) -> None:
        self.trajectory = trajectory
        self.start_s = start_s
        self._law = law
        self._correction = correction
        self._supervision = supervision

    @property
    def end_s(self) -> float:
        """When the trajectory ends (companion clock, s)."""
        return self.start_s + self.trajectory.duration_s

    @property
    def law_name(self) -> str:
        """`PLAIN` for the baseline without a correction, else `CHOSEN`: that of the flight's strategy."""
        return PLAIN if self._law is position_velocity and self._correction is None else CHOSEN

    def plain(self) -> "Tracker":
        """What tracks the same with the plain strategy."""
        return Tracker(self.trajectory, self.start_s)

    def observe(self, state: VehicleState) -> None:
        """Take in every state that arrives, not only those that a step uses."""
        if self._correction is not None:
            self._correction.observe(state)

    def forget_motion(self) -> None:
        """The vehicle's estimate jumped: what was sent before must not be paired with where it led."""
        if self._correction is not None:
            self._correction.forget_motion()

    def step(self, state: VehicleState) -> ControlStep:
        """What to send, the vehicle being in `state` (already carried to the present)."""
        time_s = state.time_s - self.start_s
        desired = self.trajectory.at(time_s)
        plain = Reference(desired.position, desired.velocity)
        u1 = self._law(self.trajectory, time_s, state)
        if self._correction is None:
            return ControlStep(desired, plain, u1, None)
        if self._supervision is None:
            online = self._correction.correct(u1, self.trajectory, time_s, state)
            return ControlStep(desired, plain, u1, online, online.u2)
        loop = self._correction.loop
        u1 = self._supervision.u1(u1, self.trajectory, time_s, state, loop)
        online = self._correction.correct(u1, self.trajectory, time_s, state)
        u2 = self._supervision.u2(online, loop)
        shares, remarks = self._supervision.shares, self._supervision.remarks()
        return ControlStep(desired, plain, u1, online, u2, shares, remarks)

    def sent(self, reference: Reference, state: VehicleState) -> tuple[float, Vec3] | None:
        """What the guard let pass: the online module learns from it, not from what was wanted.

        Returns:
            When (companion clock, s) which tracking error (m) is to be expected of it; None without a model.
        """
        if self._correction is None:
            return None
        flown_share = 1.0 if self._supervision is None else self._supervision.shares.correction
        time_s = state.time_s - self.start_s
        predicted = self._correction.sent(reference, self.trajectory, time_s, state, flown_share)
        return state.time_s + self._correction.settings.preview.longest_s, predicted.error


def tracking_error_m(state: VehicleState, desired: Sample) -> float:
    """Distance between where the vehicle is and where it should be (m)."""
    return math.dist(state.position, desired.position)
