"""One control step: desired motion, reference u1, online correction u2. No clock, no I/O."""

from dataclasses import dataclass

import numpy as np

from companion.arrays import Vec3
from companion.flight.online_correction import OnlineCorrection, OnlineStep
from companion.flight.reference import Correction, Reference
from companion.flight.strategies import ReferenceLaw, position_velocity
from companion.state import VehicleState
from companion.trajectory.trajectory import Sample, Trajectory


@dataclass(frozen=True, slots=True, eq=False)
class ControlStep:
    """What the tracker wants at one step, before the guard.

    Attributes:
        desired: the trajectory now.
        plain: the baseline's reference.
        u1: the strategy's reference.
        online: what the online module made of it, or None.
    """

    desired: Sample
    plain: Reference
    u1: Reference
    online: OnlineStep | None

    @property
    def u2(self) -> Correction:
        """The online correction; zero without an online module."""
        return Correction() if self.online is None else self.online.u2


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
    ) -> None:
        self.trajectory = trajectory
        self.start_s = start_s
        self._law = law
        self._correction = correction

    @property
    def end_s(self) -> float:
        """When the trajectory ends (companion clock, s)."""
        return self.start_s + self.trajectory.duration_s

    @property
    def law_name(self) -> str:
        """`plain` for the baseline without a correction, else `chosen`: that of the flight's strategy."""
        return "plain" if self._law is position_velocity and self._correction is None else "chosen"

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
        u1 = self._law(self.trajectory, time_s, state)
        online = (
            None if self._correction is None else self._correction.correct(u1, self.trajectory, time_s, state)
        )
        return ControlStep(desired, Reference(desired.position, desired.velocity), u1, online)

    def sent(self, reference: Reference, state: VehicleState) -> None:
        """What the guard let pass: the online module learns from it, not from what was wanted."""
        if self._correction is not None:
            self._correction.sent(reference, self.trajectory, state.time_s - self.start_s, state)


def tracking_error_m(state: VehicleState, desired: Sample) -> float:
    """Distance between where the vehicle is and where it should be (m)."""
    error: Vec3 = state.position - desired.position
    return float(np.linalg.norm(error))
