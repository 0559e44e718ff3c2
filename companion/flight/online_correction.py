"""The online module in flight: pairs what was sent with where it led, and corrects what is sent next."""

import math
from collections import deque
from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Float

from companion.arrays import Array, Vec3
from companion.autopilot.position_loop import PositionLoop, loop_of
from companion.flight.drift import SlowDrift
from companion.flight.guard import limit_length
from companion.flight.motion_history import RECENT_S, MotionHistory
from companion.flight.preview import DesiredMotion, desired_ahead, flat_state, state_of
from companion.flight.reference import Correction, Reference
from companion.flight.vertical_integral import VerticalIntegral
from companion.learning.correction import Confidence, adaptation_gain, certain_share, velocity_correction
from companion.learning.error_prediction import PredictedError, Step
from companion.learning.online_model import online_model
from companion.learning.online_settings import OnlineSettings
from companion.state import VehicleState

_USUAL_LOOP = loop_of((0.95, 1.0, 1.8, 4.0))
_BEARABLE_LATENESS_S = 0.03
"""Of telemetry: up to it the gains are as they are set."""
_LOOP_DELAY_S = 0.1
"""About what a multirotor takes from a setpoint to its acceleration. The stiffness that a loop bears goes
with the inverse square of its delay."""
_DOWN = np.array((0.0, 0.0, 1.0))
_UNDERWAY_S = 0.15
"""What was sent in so long has hardly moved the vehicle yet."""
_DRIFT_WEIGHT = 8.0
"""Of the slow drift among the innovations. An estimate that moves beside its own velocity says that this
velocity is wrong. The model is told so, and no innovation shows it; but a velocity reference would carry the
vehicle off."""


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
    """u2 = α e_p (paper, Eqn. adaptationForm) from a model of the last seconds of flight (Remark 1).

    To that comes what is held against a load (`vertical_integral`), of which the model is not told. It
    belongs to one flight. `observe` is called with each state, and once a step `correct`, then `sent`.

    Attributes:
        settings: all that it needs to be told.
        loop: the autopilot's own; PX4's by default, until a flight has asked for it.
        lateness_s: how late telemetry is, on the average (s).
    """

    def __init__(self, settings: OnlineSettings, loop: PositionLoop = _USUAL_LOOP) -> None:
        self.settings = settings
        self.loop = loop
        self.lateness_s = 0.0
        self._model = online_model(settings)
        self._confidence = Confidence(settings.caution, settings.memory)
        self._velocity_confidence = Confidence(settings.velocity_caution, settings.memory)
        self._awaiting: deque[_Sent] = deque()
        self._underway: deque[_Pull] = deque()
        self._drift = SlowDrift()
        self._vertical = VerticalIntegral(settings.vertical_integral_1_s, 0.5 * settings.longest_m)
        self._flown_share = 1.0
        self._situation: _Situation | None = None
        self._uncorrected: Reference | None = None
        self.forget_motion()
        self._previous_u2: Vec3 = np.zeros(3)

    def observe(self, state: VehicleState) -> None:
        """Take in where the vehicle was; steps whose outcome is now known become observations."""
        self._flown.append(state)
        self._drift.observe(state)
        self.lateness_s += (state.received_s - state.time_s - self.lateness_s) / self.settings.memory
        while self._awaiting and self._awaiting[0].time_s + self.settings.preview.longest_s <= state.time_s:
            self._learn(self._awaiting.popleft())

    def forget_motion(self) -> None:
        """Begin a new history, across whose beginning nothing is learned; what was learned stays."""
        self._flown = MotionHistory(2.0 * self.settings.preview.longest_s + 1.0)
        self._awaiting.clear()
        self._underway.clear()
        self._drift.forget()

    def correct(
        self, u1: Reference, trajectory: DesiredMotion, time_s: float, state: VehicleState
    ) -> OnlineStep:
        """The correction for u1 at `time_s` on the trajectory (s), the vehicle being in `state`.

        Once a step: what is predicted counts towards the confidence, and the vertical error is integrated.
        """
        self._uncorrected = u1
        predicted = self._model.predict(self._step(u1, trajectory, time_s, state))
        if not len(self._model):
            return OnlineStep(Correction(), predicted, np.zeros(3))
        loop = self._felt_loop()
        self._confidence.expect(predicted.error)
        self._velocity_confidence.expect(predicted.velocity_error)
        error, velocity_error = self._to_correct(predicted, u1, trajectory, time_s)
        share = self._confidence.share * certain_share(
            error, predicted.variance, self.settings.variance_caution
        )
        alpha = share * adaptation_gain(
            self.settings.gain, predicted.gradient, predicted.gradient_variance, loop.stiffness_1_s2
        )
        deviation_m = self._flown_share * float(trajectory.at(time_s).position[2] - state.position[2])
        load_m = self._vertical.add(deviation_m, float(alpha[2]), self.settings.sample_time_s)
        u2 = limit_length(alpha * error + load_m * _DOWN, self.settings.longest_m)
        velocity = self._velocity_correction(u2, velocity_error, loop)
        self._previous_u2 = u2
        correction = within_pull(Correction(u2, velocity), self.loop, self.settings.sideways_m_s2)
        return OnlineStep(correction, predicted, alpha)

    def sent(
        self,
        reference: Reference,
        trajectory: DesiredMotion,
        time_s: float,
        state: VehicleState,
        flown_share: float = 1.0,
    ) -> PredictedError:
        """Remember what was sent at `state` until it is known where it led; what is expected of that.

        Once a step, after `correct`: what the correction asked for is told by the difference from its u1.
        `flown_share` of the correction is in it. What is held against the load is left out, as the load is:
        together they move nothing.
        """
        self._flown_share = flown_share
        unloaded = reference.position - self._vertical.offset_m * _DOWN
        reference = replace(reference, position=unloaded)
        step = self._step(reference, trajectory, time_s, state)
        predicted = self._model.predict(step)
        self._awaiting.append(_Sent(state.time_s, step, predicted))
        if self._uncorrected is not None:
            pull = self._uncorrected.pull_towards(reference, *self.loop)
            self._underway.append(_Pull(state.time_s, pull))
        return predicted

    def _learn(self, sent: "_Sent") -> None:
        preview = self.settings.preview
        position = self._flown.position(sent.time_s, preview.position_s)
        velocity = self._flown.velocity(sent.time_s, preview.velocity_s)
        if self._model.learn(sent.step, position, velocity):
            self._confidence.compare(position - sent.predicted.position)
            innovation = velocity - sent.predicted.velocity
            self._velocity_confidence.compare(
                np.concatenate((innovation, _DRIFT_WEIGHT * self._drift.velocity))
            )

    def _felt_loop(self) -> PositionLoop:
        """The autopilot's loop as a late link makes it: the later, the less correction it bears."""
        late_s = 2.0 * max(self.lateness_s - _BEARABLE_LATENESS_S, 0.0)
        slower = 1.0 + late_s / _LOOP_DELAY_S
        return PositionLoop(self.loop.stiffness_1_s2 * slower**2, self.loop.damping_1_s * slower)

    def _to_correct(
        self, predicted: PredictedError, u1: Reference, trajectory: DesiredMotion, time_s: float
    ) -> tuple[Vec3, Vec3]:
        """What is to be corrected of the predicted errors of position (m) and velocity (m/s)."""
        if self.settings.corrected == "error":
            return predicted.error, predicted.velocity_error
        there = self._model.predict(self._operating_point(u1, trajectory, time_s))
        return predicted.error - there.error, predicted.velocity_error - there.velocity_error

    def _operating_point(self, u1: Reference, trajectory: DesiredMotion, time_s: float) -> Step:
        """The step of a vehicle that is exactly on its trajectory."""
        return Step(
            *(flat_state(trajectory, time_s), u1.position, u1.velocity),
            *desired_ahead(trajectory, time_s, self.settings.preview),
            np.zeros(3) if u1.acceleration is None else u1.acceleration,
            acceleration=trajectory.at(time_s - 0.5 * RECENT_S).acceleration,
            drift=np.zeros(3),
            underway=np.zeros(3),
        )

    def _velocity_correction(self, u2: Vec3, velocity_error: Vec3, loop: PositionLoop) -> Vec3:
        match self.settings.velocity:
            case "finite_difference":
                return velocity_correction(u2, self._previous_u2, self.settings.sample_time_s)
            case "predicted":
                gain = self._velocity_confidence.share * self.settings.damping_1_s / loop.damping_1_s
                # The autopilot believes the velocity that drifts: it is asked for as much less.
                return gain * velocity_error - self._drift.velocity
            case "uncorrected":
                return np.zeros(3)

    def _step(self, u: Reference, trajectory: DesiredMotion, time_s: float, state: VehicleState) -> Step:
        asked = (trajectory, time_s, state)
        if self._situation is None or self._situation.asked != asked:
            desired = desired_ahead(trajectory, time_s, self.settings.preview)
            recent = (*self._flown.recent(state), self._pull_underway(state.time_s))
            self._situation = _Situation(asked, state_of(state), desired, recent)
        now = self._situation
        feedforward = np.zeros(3) if u.acceleration is None else u.acceleration
        return Step(now.x, u.position, u.velocity, *now.desired, feedforward, *now.recent)

    def _pull_underway(self, time_s: float) -> Vec3:
        """The mean of what corrections asked for in the last `_UNDERWAY_S` before `time_s` (m/s²)."""
        while self._underway and self._underway[0].time_s < time_s - _UNDERWAY_S:
            self._underway.popleft()
        if not self._underway:
            return np.zeros(3)
        mean: Vec3 = np.mean([sent.acceleration for sent in self._underway], axis=0)
        return mean


def within_pull(correction: Correction, loop: PositionLoop, sideways_m_s2: float) -> Correction:
    """The correction, scaled down horizontally until it pulls no harder than this (m/s²)."""
    north, east, _ = correction.pull(*loop)
    pull_m_s2 = math.hypot(north, east)
    if not pull_m_s2 > sideways_m_s2:
        return correction
    part = np.array((sideways_m_s2 / pull_m_s2, sideways_m_s2 / pull_m_s2, 1.0))
    return Correction(part * correction.position, part * correction.velocity)


@dataclass(frozen=True, slots=True, eq=False)
class _Situation:
    """What of a step is the same for every reference: for that to be corrected, and for that then sent.

    Attributes:
        asked: trajectory, time on it (s) and state.
        x: the state vector.
        desired: position (m) and velocity (m/s), one preview ahead.
        recent: acceleration (m/s²), drift (m/s) and the pull of corrections under way (m/s²).
    """

    asked: tuple[DesiredMotion, float, VehicleState]
    x: Float[Array, "12"]
    desired: tuple[Vec3, Vec3]
    recent: tuple[Vec3, Vec3, Vec3]


@dataclass(frozen=True, slots=True, eq=False)
class _Sent:
    """A step that was sent at `time_s` (s), and what the model expected of it."""

    time_s: float
    step: Step
    predicted: PredictedError


@dataclass(frozen=True, slots=True, eq=False)
class _Pull:
    """The acceleration (m/s²) that a correction sent at `time_s` (s) asked for."""

    time_s: float
    acceleration: Vec3
