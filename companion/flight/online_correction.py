"""The online module in flight: pairs what was sent with where it led, and corrects what is sent next."""

from bisect import bisect_left
from collections import deque
from dataclasses import dataclass

import numpy as np

from companion.arrays import Vec3
from companion.flight.preview import desired_ahead, state_of
from companion.flight.reference import Correction, Reference
from companion.learning.correction import adaptation_gain, velocity_correction
from companion.learning.error_prediction import ErrorModel, PredictedError, Step
from companion.learning.online_settings import OnlineSettings
from companion.state import VehicleState
from companion.trajectory.trajectory import Trajectory

_LONGEST_GAP_S = 0.2
"""Between two states further apart than this, no position is interpolated."""


@dataclass(frozen=True, slots=True, eq=False)
class OnlineStep:
    """What the online module made of one control step.

    Attributes:
        u2: the correction.
        predicted: what u1 alone would lead to.
        alpha: gain of each axis.
    """

    u2: Correction
    predicted: PredictedError
    alpha: Vec3


class OnlineCorrection:
    """u2 = α e_p (paper, Eqn. adaptationForm) from a model of the last seconds of flight (Remark 1)."""

    def __init__(self, settings: OnlineSettings) -> None:
        self.settings = settings
        self._model = ErrorModel(settings.form, settings.kernel, settings.window)
        self._flown = PositionHistory(settings.preview.longest_s + 2.0)
        self._awaiting: deque[tuple[float, Step]] = deque()
        self._previous_u2 = np.zeros(3)

    def observe(self, state: VehicleState) -> None:
        """Take in where the vehicle was; steps whose outcome is now known become observations."""
        self._flown.append(state.time_s, state.position)
        leads_s = self.settings.preview.position_s
        while self._awaiting and self._awaiting[0][0] + max(leads_s) <= state.time_s:
            time_s, step = self._awaiting.popleft()
            flown = [self._flown.at(time_s + lead_s)[axis] for axis, lead_s in enumerate(leads_s)]
            self._model.learn(step, np.array(flown))

    def correct(
        self, u1: Reference, trajectory: Trajectory, time_s: float, state: VehicleState
    ) -> OnlineStep:
        """The correction for u1 at `time_s` on the trajectory (s), the vehicle being in `state`."""
        step = self._step(u1, trajectory, time_s, state)
        predicted = self._model.predict(step)
        alpha = adaptation_gain(self.settings.gain, predicted.gradient)
        u2 = alpha * predicted.error if len(self._model) else np.zeros(3)
        velocity: Vec3 = np.zeros(3)
        if self.settings.velocity == "finite_difference":
            velocity = velocity_correction(u2, self._previous_u2, self.settings.sample_time_s)
        self._previous_u2 = u2
        return OnlineStep(Correction(u2, velocity), predicted, alpha)

    def sent(self, reference: Reference, trajectory: Trajectory, time_s: float, state: VehicleState) -> None:
        """Remember what was sent at `state`, until it is known where it led."""
        self._awaiting.append((state.time_s, self._step(reference, trajectory, time_s, state)))

    def _step(self, u: Reference, trajectory: Trajectory, time_s: float, state: VehicleState) -> Step:
        desired = desired_ahead(trajectory, time_s, self.settings.preview)
        return Step(state_of(state), u.position, u.velocity, *desired)


class PositionHistory:
    """Where the vehicle was during the last `span_s` seconds, at any instant between."""

    def __init__(self, span_s: float) -> None:
        self._span_s = span_s
        self._times: list[float] = []
        self._positions: list[Vec3] = []

    def append(self, time_s: float, position: Vec3) -> None:
        """Take in the newest position (m, NED); times rise."""
        self._times.append(time_s)
        self._positions.append(position)
        if self._times[0] < time_s - 2.0 * self._span_s:  # rarely, so that it costs little
            kept = bisect_left(self._times, time_s - self._span_s)
            del self._times[:kept], self._positions[:kept]

    def at(self, time_s: float) -> Vec3:
        """The position at `time_s` (s), linear between two states; NaN where none are near enough."""
        after = bisect_left(self._times, time_s)
        if after == len(self._times) or (after == 0 and self._times[0] > time_s):
            return np.full(3, np.nan)
        if self._times[after] == time_s:
            return self._positions[after]
        gap_s = self._times[after] - self._times[after - 1]
        if gap_s > _LONGEST_GAP_S:
            return np.full(3, np.nan)
        share = (time_s - self._times[after - 1]) / gap_s
        return (1.0 - share) * self._positions[after - 1] + share * self._positions[after]
