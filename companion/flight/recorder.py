"""Says what happens in a flight, as it happens, to whatever takes it in: a file, or the memory."""

import json
from collections import deque
from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from companion.flight.guard import Guarded
from companion.flight.recent import Recent
from companion.flight.reference import Reference
from companion.flight.tracker import ControlStep, Tracker
from companion.learning.negative_transfer import loop_gain
from companion.recording import scene, topics
from companion.recording.collected import Collected
from companion.recording.series import Provenance, Recording, rows
from companion.recording.sink import Sink
from companion.recording.topics import Level, Row
from companion.state import VehicleState

_POSE_EVERY_S = 0.1
_PATH_POINTS = 1000
_MOST_EVENTS = 10_000
"""Of more, the newest are kept in memory; the sink has had them all."""


class Recorder:
    """Makes messages of states, control steps and events, in the order in which they come.

    Args:
        sink: takes them in.
        epoch_s: date (Unix time, s) of the zero of the companion clock.

    Attributes:
        events: when what happened, in words (companion clock, s).
        recent: what was measured and sent in the newest seconds.
    """

    def __init__(self, sink: Sink, epoch_s: float = 0.0) -> None:
        self.events: deque[tuple[float, str]] = deque(maxlen=_MOST_EVENTS)
        self.recent = Recent()
        self._sink = sink
        self._epoch_s = epoch_s
        self._posed_s = -np.inf
        self._trajectories = 0

    def state(self, state: VehicleState) -> None:
        """A state arrived."""
        self.recent.state(state)
        values: Row = {
            "position": state.position,
            "velocity": state.velocity,
            "attitude": state.attitude,
            "rates": state.rates,
            "received_s": state.received_s,
        }
        self._sink.add(topics.STATE, state.time_s, topics.row(topics.STATE, values))
        if state.time_s >= self._posed_s + _POSE_EVERY_S and state.is_finite():
            self._posed_s = state.time_s
            pose = scene.pose(self._unix_ns(state.time_s), state.position, state.attitude)
            self._sink.add(scene.POSE, state.time_s, pose)

    def control(self, time_s: float, settings: str) -> None:
        """The control loop begins, with these settings (JSON)."""
        self._sink.add(topics.CONTROL, time_s, {"settings": settings})

    def follow(self, time_s: float, tracker: Tracker) -> None:
        """From now on this is tracked."""
        trajectory = tracker.trajectory
        self._trajectories += 1
        name = f"trajectory {self._trajectories}"
        self._sink.attach(name, np.ascontiguousarray(trajectory.coefficients, dtype="<f8").tobytes())
        values = {
            "start_s": tracker.start_s,
            "duration_s": trajectory.duration_s,
            "step_s": trajectory.step_s,
        }
        texts = {"name": trajectory.name, "law": tracker.law_name, "attachment": name}
        self._sink.add(topics.TRAJECTORY, time_s, topics.row(topics.TRAJECTORY, values) | texts)
        times_s = np.linspace(0.0, trajectory.duration_s, _PATH_POINTS)
        path = scene.path(self._unix_ns(time_s), trajectory.sample(times_s).position)
        self._sink.add(scene.PATH, time_s, path)

    def step(self, time_s: float, step: ControlStep, guarded: Guarded, sent: Reference, yaw: float) -> None:
        """`sent` was sent, with this yaw (rad); it is what was guarded, in the vehicle's own frame."""
        self.recent.sent(time_s, sent, yaw)
        reference: Row = {
            "position": sent.position,
            "velocity": sent.velocity,
            "acceleration": sent.acceleration,
            "yaw": yaw,
        }
        self._sink.add(topics.REFERENCE, time_s, topics.row(topics.REFERENCE, reference))
        self._sink.add(topics.TRACKING, time_s, topics.row(topics.TRACKING, _tracking(step, guarded)))
        if guarded.clips:
            moved = guarded.reference.position - step.u1.position - step.u2.position
            fields = topics.row(topics.GUARD, {"moved": moved})
            self._sink.add(topics.GUARD, time_s, fields | {"clips": "; ".join(guarded.clips)})

    def event(
        self,
        time_s: float,
        text: str,
        kind: str = "flight",
        data: Mapping[str, Any] | None = None,
        level: Level = Level.INFO,
    ) -> None:
        """Something happened that a reader of the log wants to know.

        Args:
            time_s: when (companion clock, s).
            text: for people.
            kind: for programs, such as `guard`; events of one kind have the same `data`.
            data: what JSON can say.
            level: how grave it is.
        """
        self.events.append((time_s, text))
        said = json.dumps(data) if data else ""
        self._sink.add(topics.EVENTS, time_s, topics.event(self._unix_ns(time_s), text, kind, said, level))

    def parameter(self, time_s: float, name: str, value: float) -> None:
        """The vehicle told a parameter."""
        fields = topics.row(topics.PARAMETERS, {"value": value})
        self._sink.add(topics.PARAMETERS, time_s, fields | {"name": name})

    def metadata(self, name: str, values: dict[str, Any]) -> None:
        """What is known once, by one of the names in `topics.METADATA`."""
        self._sink.add_metadata(name, values)

    def recording(self, provenance: Provenance) -> Recording:
        """What is in memory of the flight: its events."""
        return replace(Collected().recording(provenance), events=tuple(self.events))

    def _unix_ns(self, time_s: float) -> int:
        return round((self._epoch_s + time_s) * 1e9)


class FlightRecorder(Recorder):
    """Keeps a flight in memory."""

    def __init__(self) -> None:
        self._collected = Collected()
        super().__init__(self._collected)

    def recording(self, provenance: Provenance) -> Recording:
        """All that happened so far, its states in the order of their times."""
        recording = self._collected.recording(provenance)
        in_order = np.argsort(recording.states.time_s, kind="stable")
        return replace(recording, states=rows(recording.states, in_order))


def _tracking(step: ControlStep, guarded: Guarded) -> Row:
    """The row of a control step; u2 is what the guard left of it."""
    online = step.online
    predicted = None if online is None else online.predicted
    return {
        "desired_position": step.desired.position,
        "desired_velocity": step.desired.velocity,
        "desired_acceleration": step.desired.acceleration,
        "u1": step.u1.position,
        "u1_velocity": step.u1.velocity,
        "u1_acceleration": step.u1.acceleration,
        "u2": guarded.correction.position,
        "u2_velocity": guarded.correction.velocity,
        "predicted_position": None if predicted is None else predicted.position,
        "predicted_variance": None if predicted is None else np.full(3, predicted.variance),
        "alpha": None if online is None else online.alpha,
        "loop_gain": None if online is None else loop_gain(online.alpha, online.predicted.gradient),
        "network_share": None if step.shares is None else step.shares.network,
        "correction_share": None if step.shares is None else step.shares.correction,
    }
