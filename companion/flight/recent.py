"""The newest seconds of a flight, in memory: what was measured, and what was sent."""

from collections import deque

import numpy as np

from companion.flight.reference import Reference
from companion.recording.series import ReferenceSeries, StateSeries
from companion.state import VehicleState

SPAN_S = 20.0
_MOST = 4000
"""Of each, however often they come."""
_SENDING_S = 0.5
"""So long after a setpoint the vehicle answers to it; later states, as of a landing, do not count."""


class Recent:
    """Keeps states while setpoints are sent, and the setpoints; the newest win."""

    def __init__(self) -> None:
        self._states: deque[VehicleState] = deque(maxlen=_MOST)
        self._sent: deque[tuple[float, Reference, float]] = deque(maxlen=_MOST)

    def state(self, state: VehicleState) -> None:
        """A state arrived."""
        if not self._sent or state.time_s > self._sent[-1][0] + _SENDING_S:
            return
        self._states.append(state)
        while self._states[0].time_s < state.time_s - SPAN_S:
            self._states.popleft()

    def sent(self, time_s: float, reference: Reference, yaw: float) -> None:
        """`reference` was sent at `time_s` (companion clock, s), with this yaw (rad)."""
        self._sent.append((time_s, reference, yaw))
        while self._sent[0][0] < time_s - SPAN_S:
            self._sent.popleft()

    def series(self) -> tuple[StateSeries, ReferenceSeries]:
        """What is kept, the states in the order of their times."""
        states = sorted(self._states, key=lambda state: state.time_s)
        unsent = np.full(3, np.nan)
        accelerations = [
            unsent if sent.acceleration is None else sent.acceleration for _, sent, _ in self._sent
        ]
        return (
            StateSeries(
                np.array([state.time_s for state in states]),
                *(
                    np.array([getattr(state, part) for state in states]).reshape(-1, 3)
                    for part in ("position", "velocity", "attitude", "rates")
                ),
            ),
            ReferenceSeries(
                np.array([time_s for time_s, _, _ in self._sent]),
                np.array([sent.position for _, sent, _ in self._sent]).reshape(-1, 3),
                np.array([sent.velocity for _, sent, _ in self._sent]).reshape(-1, 3),
                np.array(accelerations).reshape(-1, 3),
                np.array([yaw for _, _, yaw in self._sent]),
            ),
        )
