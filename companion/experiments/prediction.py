"""How well the online model predicts a recorded flight, without any simulator.

Recorded states and references go through the very class that corrects in flight, step by step: it knows what
had been flown by then, and what was to be sent until one horizon later, as it would of a trajectory.
"""

from bisect import bisect_right
from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from companion.arrays import Vec3
from companion.errors import InputError
from companion.flight.motion_history import MotionHistory
from companion.flight.online_correction import OnlineCorrection
from companion.flight.reference import Reference
from companion.learning.features import Preview
from companion.learning.online_settings import DEFAULT, OnlineSettings
from companion.recording.segments import Segment, Window
from companion.recording.series import Recording, ReferenceSeries, Series, StateSeries, rows
from companion.state import VehicleState
from companion.trajectory.trajectory import Sample

HORIZONS_S = (0.2, 0.36)


@dataclass(frozen=True)
class Prediction:
    """RMS distance of where the vehicle was one horizon later and where it was expected (m).

    Attributes:
        gp_rms_m: expected by the online model.
        constant_velocity_rms_m: by going on as it went.
        setpoint_rms_m: at the setpoint of the time.
    """

    gp_rms_m: float
    constant_velocity_rms_m: float
    setpoint_rms_m: float


class _Step(NamedTuple):
    """One control step: the newest state, the position sent, and that expected one horizon later (m)."""

    state: VehicleState
    setpoint: Vec3
    expected: Vec3


def prediction_errors(
    recording: Recording,
    segment: Segment,
    horizons: Sequence[float] = HORIZONS_S,
    settings: OnlineSettings = DEFAULT,
) -> dict[float, Prediction]:
    """Errors of predicting one segment, by horizon (s); the model knows nothing when the segment begins.

    Counted are the control steps that sent a position and whose outcome was recorded within the segment.

    Raises:
        InputError: there is no such step.
    """
    return {horizon_s: _prediction(recording, segment, horizon_s, settings) for horizon_s in horizons}


def _prediction(
    recording: Recording, segment: Segment, horizon_s: float, settings: OnlineSettings
) -> Prediction:
    states = _states(_within(recording.states, segment.window))
    references = _within(recording.references, segment.window)
    ahead = settings.model_copy(update={"preview": Preview.of_time(horizon_s)})
    steps = _streamed(states, references, OnlineCorrection(ahead))
    flown = MotionHistory(span_s=np.inf)
    for state in states:
        flown.append(state)
    came = [flown.position(step.state.time_s, (horizon_s,) * 3) for step in steps]
    errors = np.array(
        [
            (
                outcome - step.expected,
                outcome - step.state.position - horizon_s * step.state.velocity,
                outcome - step.setpoint,
            )
            for step, outcome in zip(steps, came, strict=True)
            if np.isfinite(outcome).all()
        ]
    )
    if not len(errors):
        raise InputError(
            f"segment {segment.id}: no position was sent to a vehicle that was seen {horizon_s:g} s later"
        )
    return Prediction(*np.sqrt(np.mean(np.sum(errors**2, axis=2), axis=0)).tolist())


def _streamed(
    states: Sequence[VehicleState], references: ReferenceSeries, correction: OnlineCorrection
) -> list[_Step]:
    """Each position that was sent meets the newest state; a state is observed when its time has come."""
    steps: list[_Step] = []
    desired = _Held(references)
    observed = 0
    for now_s in references.time_s.tolist():
        while observed < len(states) and states[observed].time_s <= now_s:
            correction.observe(states[observed])
            observed += 1
        sent = Reference(*desired.at(now_s))
        if observed and np.isfinite(sent.position).all():
            state = states[observed - 1]
            expected = correction.sent(sent, desired, state.time_s, state)
            steps.append(_Step(state, sent.position, expected.position))
    return steps


class _Held:
    """What was sent as a desired motion: each setpoint until the next; what was not sent of it is zero."""

    def __init__(self, references: ReferenceSeries) -> None:
        self._time_s = references.time_s.tolist()
        self._position = references.position
        self._velocity = np.nan_to_num(references.velocity)
        self._acceleration = np.nan_to_num(references.acceleration)

    def at(self, time_s: float) -> Sample:
        """The last setpoint until `time_s` of the recording's clock (s), before the first one the first."""
        row = max(bisect_right(self._time_s, time_s) - 1, 0)
        return Sample(self._position[row], self._velocity[row], self._acceleration[row])


def _within(series: Series, window: Window) -> Series:
    return rows(series, np.flatnonzero((series.time_s >= window.start_s) & (series.time_s <= window.end_s)))


def _states(series: StateSeries) -> list[VehicleState]:
    columns = (series.position, series.velocity, series.attitude, series.rates)
    return [
        VehicleState(time_s, time_s, *motion)
        for time_s, *motion in zip(series.time_s.tolist(), *columns, strict=True)
    ]
