"""Keeps what a flight was, for its error and its log."""

import numpy as np

from companion.arrays import Array, Vec3
from companion.flight.guard import Guarded
from companion.flight.tracker import ControlStep
from companion.recording.series import Provenance, Recording, ReferenceSeries, StateSeries, TrackingSeries
from companion.state import VehicleState

_NOTHING: Vec3 = np.full(3, np.nan)


class FlightRecorder:
    """Takes in states, control steps and events as they come; gives them back as one `Recording`."""

    def __init__(self) -> None:
        self._states: list[VehicleState] = []
        self._steps: list[tuple[float, ControlStep, Guarded]] = []
        self._yaws: list[float] = []
        self._events: list[tuple[float, str]] = []

    def state(self, state: VehicleState) -> None:
        """A state arrived."""
        self._states.append(state)

    def step(self, time_s: float, step: ControlStep, guarded: Guarded, yaw: float) -> None:
        """A reference was sent, with this yaw (rad)."""
        self._steps.append((time_s, step, guarded))
        self._yaws.append(yaw)

    def event(self, time_s: float, text: str) -> None:
        """Something happened that a reader of the log wants to know."""
        self._events.append((time_s, text))

    def recording(self, provenance: Provenance) -> Recording:
        """All that was taken in so far."""
        return Recording(
            provenance, self._state_series(), self._references(), self._tracking(), tuple(self._events)
        )

    def _state_series(self) -> StateSeries:
        states = sorted(self._states, key=lambda state: state.time_s)
        return StateSeries(
            time_s=np.array([state.time_s for state in states]),
            position=_rows([state.position for state in states]),
            velocity=_rows([state.velocity for state in states]),
            attitude=_rows([state.attitude for state in states]),
            rates=_rows([state.rates for state in states]),
        )

    def _references(self) -> ReferenceSeries:
        sent = [guarded.reference for _, _, guarded in self._steps]
        return ReferenceSeries(
            time_s=np.array([time_s for time_s, _, _ in self._steps]),
            position=_rows([reference.position for reference in sent]),
            velocity=_rows([reference.velocity for reference in sent]),
            acceleration=_rows(
                [_NOTHING if reference.acceleration is None else reference.acceleration for reference in sent]
            ),
            yaw=np.array(self._yaws),
        )

    def _tracking(self) -> TrackingSeries:
        steps = [step for _, step, _ in self._steps]
        online = [step.online for step in steps]
        return TrackingSeries(
            time_s=np.array([time_s for time_s, _, _ in self._steps]),
            desired_position=_rows([step.desired.position for step in steps]),
            desired_velocity=_rows([step.desired.velocity for step in steps]),
            desired_acceleration=_rows([step.desired.acceleration for step in steps]),
            u1=_rows([step.u1.position for step in steps]),
            u2=_rows([guarded.correction.position for _, _, guarded in self._steps]),
            predicted_position=_rows([_NOTHING if o is None else o.predicted.position for o in online]),
            predicted_variance=_rows(
                [_NOTHING if o is None else np.full(3, o.predicted.variance) for o in online]
            ),
            alpha=_rows([_NOTHING if o is None else o.alpha for o in online]),
        )


def _rows(vectors: list[Vec3]) -> Array:
    return np.array(vectors, dtype=np.float64).reshape(-1, 3)
