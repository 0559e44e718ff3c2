"""Flights from their own recordings: what was to be flown, what was flown, and how far apart both were."""

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from companion.arrays import Times, Vec3s
from companion.errors import InputError
from companion.experiments.flights import Flight
from companion.flight.recorded_inputs import Followed, recorded_inputs
from companion.recording.card import log_name
from companion.recording.files import read_recording
from companion.recording.metrics import TrackingAccuracy, tracking_accuracy
from companion.recording.series import Recording
from companion.trajectory.trajectory import Trajectory

_MOVING_M_S = 0.01


@dataclass(frozen=True, eq=False)
class LoggedFlight:
    """A flight as its file has it.

    Attributes:
        path: the file.
        recording: all of it.
        flight: the part in which its trajectory was tracked.
        accuracy: there, against the vehicle's own estimate.
    """

    path: Path
    recording: Recording
    flight: Flight
    accuracy: TrackingAccuracy

    @property
    def largest_correction_m(self) -> float | None:
        """The longest u2 of the tracked part (m); None where nothing was tracked by us."""
        tracking = self.recording.tracking
        if tracking is None:
            return None
        within = (tracking.time_s >= self.flight.time_s[0]) & (tracking.time_s <= self.flight.time_s[-1])
        return float(np.linalg.norm(tracking.u2[within], axis=1).max(initial=0.0))


def read_logged_flight(path: Path) -> LoggedFlight:
    """The flight in a recording of ours, whole or cut short, or in a `.tlog` or `.ulg`.

    What was to be flown is the trajectory as it was flown; in recordings that do not hold it, the desired
    positions of the control steps; in logs of others, what was sent.

    Raises:
        InputError: the file cannot be read, or ends before anything was tracked.
    """
    recording = read_recording(path)
    followed = _followed(path, recording)
    time_s, desired = _desired(recording) if followed is None else _planned(followed, recording)
    if len(time_s) < 2:
        raise InputError(f"{path}: ends before anything was tracked, or nothing was")
    flown = _at(time_s, recording.states.time_s, recording.states.position)
    accuracy = tracking_accuracy(lambda _: desired, time_s, flown, time_s[0], time_s[-1])
    about = recording.provenance
    name, strategy = about.trajectory or log_name(path), about.strategy or "setpoints"
    begun_s = None if followed is None else followed.start_s
    flight = Flight(name, strategy, time_s, desired, flown, accuracy.rms_m, begun_s)
    return LoggedFlight(path, recording, flight, accuracy)


def told_apart(flights: list[LoggedFlight]) -> list[LoggedFlight]:
    """The same flights; those that share trajectory and strategy are called by their files' names, too."""
    names = [(each.flight.trajectory_name, each.flight.strategy) for each in flights]
    return [
        each
        if names.count(name) == 1
        else replace(each, flight=replace(each.flight, strategy=f"{each.flight.strategy} ({each.path.stem})"))
        for each, name in zip(flights, names, strict=True)
    ]


def _followed(path: Path, recording: Recording) -> Followed | None:
    """The trajectory that the flight was about, where the file has it, when it was begun."""
    if path.suffix.lower() != ".mcap":
        return None
    followed = [each for each in recorded_inputs(path) if isinstance(each, Followed)]
    named = [each for each in followed if each.trajectory.name == recording.provenance.trajectory]
    return named[0] if named else None


def _planned(followed: Followed, recording: Recording) -> tuple[Times, Vec3s]:
    """Times of the states while the trajectory was tracked, and where it was at them."""
    trajectory: Trajectory = followed.trajectory
    time_s, sent_s = recording.states.time_s, recording.references.time_s
    begun_s = max(followed.start_s, followed.time_s)
    ended_s = min(followed.start_s + trajectory.duration_s, sent_s.max(initial=begun_s))
    along = time_s[(time_s >= begun_s) & (time_s <= ended_s)]
    return along, trajectory.sample(along - followed.start_s).position


def _desired(recording: Recording) -> tuple[Times, Vec3s]:
    """Times of the control steps from the first to the last motion, and what was desired at them."""
    tracking, sent = recording.tracking, recording.references
    if tracking is None:
        known = np.isfinite(sent.position).all(axis=1)
        return sent.time_s[known], sent.position[known]
    moving = np.flatnonzero(np.linalg.norm(tracking.desired_velocity, axis=1) > _MOVING_M_S)
    part = slice(moving[0], moving[-1] + 1) if len(moving) else slice(0)
    return tracking.time_s[part], tracking.desired_position[part]


def _at(time_s: Times, known_s: Times, values: Vec3s) -> Vec3s:
    """`values` at `time_s`, linear between `known_s`."""
    return np.column_stack([np.interp(time_s, known_s, column) for column in values.T])
