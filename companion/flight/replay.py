"""A recorded flight, computed again by today's code from what it saw: the same bits, when nothing changed.

What goes in, in the order in which it came: settings, trajectories, states, and the instants of the control
steps. What came out, `/reference`, `/tracking` and `/guard`, is compared number by number.
"""

from collections import deque
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any, TypeAlias

from companion.errors import FlightError, InputError, TrackingError
from companion.flight.control import Control
from companion.flight.differences import Difference, Differences
from companion.flight.online_correction import OnlineCorrection
from companion.flight.recorded_inputs import OUTPUTS, Began, Followed, recorded_inputs
from companion.flight.recorder import Recorder
from companion.flight.strategies import ReferenceLaw, reference_law
from companion.flight.supervision import Supervision, supervision_of
from companion.flight.technique import Technique
from companion.flight.tracker import PLAIN, Tracker
from companion.learning.inverse_network import InverseNetwork
from companion.learning.library import Library
from companion.recording.mcap_reader import CutShort, Message
from companion.recording.topics import REFERENCE, Fields
from companion.state import VehicleState

FindNetwork: TypeAlias = Callable[[Technique], InverseNetwork | Library | None]


@dataclass(frozen=True)
class Replayed:
    """A flight that was computed again.

    Attributes:
        steps: how many control steps.
        start_s: the first of them (companion clock, s).
        differences: the signals that came out otherwise, the first to do so first.
        whole: whether the recording has its end.
    """

    steps: int
    start_s: float
    differences: tuple[Difference, ...]
    whole: bool


def replay(path: Path, find_network: FindNetwork) -> Replayed:
    """Compute the flight in `path` (MCAP) again.

    Args:
        path: written while it was flown.
        find_network: gives the network that was flown with, if one was.

    Raises:
        InputError: the file cannot be read, is damaged, or holds no control loop's inputs.
        FlightError: today's code ends the flight.
    """
    again = _Again(find_network)
    whole = True
    for found in recorded_inputs(path):
        match found:
            case Technique():
                again.technique = found
            case Began():
                again.begin(found)
            case Followed():
                again.follow(found)
            case VehicleState():
                again.observe(found)
            case Message(topic, time_s, fields):
                again.compare(topic, time_s, fields)
            case CutShort():
                whole = False
    if again.start_s is None:
        raise InputError(f"{path}: no control loop in it: `fly` and `collect` record what can be replayed")
    return Replayed(again.steps, again.start_s, again.differences.found(), whole)


class _Again:
    """The control loop of a flight, computed again input by input."""

    def __init__(self, find_network: FindNetwork) -> None:
        self.technique: Technique | None = None
        self.differences = Differences()
        self.steps = 0
        self.start_s: float | None = None
        self._find_network = find_network
        self._outputs = _Outputs()
        self._newest: VehicleState | None = None
        self._began: Began | None = None
        self._control: Control | None = None

    def begin(self, began: Began) -> None:
        """Another loop begins, which the first tracker that follows completes."""
        self._began, self._control = began, None

    def follow(self, followed: Followed) -> None:
        """The flight came to another trajectory."""
        tracker = self._tracker(followed)
        if self._control is not None:
            self._control.follow(followed.time_s, tracker)
        elif self._began is not None:
            self._control = Control(self._began.settings, tracker, Recorder(self._outputs))
            self._control.begin(self._began.time_s, self._newest)

    def observe(self, state: VehicleState) -> None:
        """A state arrived."""
        self._newest = state
        if self._control is not None:
            self._control.observe(state)

    def compare(self, topic: str, time_s: float, recorded: Fields) -> None:
        """The flight put out a message; a reference means that a step was taken."""
        if topic == REFERENCE:
            self._step(time_s)
        fields = self._outputs.take(topic, time_s)
        if fields is None:
            self.differences.missing(topic, time_s)
        else:
            self.differences.compare(topic, time_s, recorded, fields)

    def _step(self, time_s: float) -> None:
        if self._control is None or self._control.newest is None:
            return
        self.steps += 1
        self.start_s = time_s if self.start_s is None else self.start_s
        try:
            self._control.setpoint(time_s, self._control.newest.at(time_s))
        except TrackingError as error:
            after_s = time_s - self.start_s
            raise FlightError(
                f"today's code ends the flight {after_s:.2f} s after its begin: {error}"
            ) from error

    def _tracker(self, followed: Followed) -> Tracker:
        if followed.law == PLAIN:
            return Tracker(followed.trajectory, followed.start_s)
        return Tracker(followed.trajectory, followed.start_s, *self._chosen)

    @cached_property
    def _chosen(self) -> tuple[ReferenceLaw, OnlineCorrection | None, Supervision | None]:
        """What all trackers of the flight share."""
        technique = self.technique
        if technique is None:
            raise InputError("the recording does not say by which strategy was flown")
        network = self._find_network(technique)
        lookahead_s = technique.lookahead_s
        if lookahead_s is None and isinstance(network, InverseNetwork):
            lookahead_s = network.card.lookahead_s
        online = technique.online
        correction = OnlineCorrection(online) if technique.strategy.learns_online else None
        loop = None if self._began is None else self._began.settings.loop
        if correction is not None and loop is not None:
            correction.loop = loop
        law = reference_law(technique.strategy, network=network, lookahead_s=lookahead_s, online=online)
        return law, correction, supervision_of(technique.strategy, network, online)


class _Outputs:
    """A `Sink` that keeps the outputs, until they are asked for."""

    def __init__(self) -> None:
        self._waiting: dict[str, deque[tuple[float, Fields]]] = {topic: deque() for topic in OUTPUTS}

    def add(self, topic: str, time_s: float, fields: Fields) -> None:
        if topic in self._waiting:
            self._waiting[topic].append((time_s, fields))

    def add_metadata(self, name: str, values: dict[str, Any]) -> None:
        """No output."""

    def attach(self, name: str, data: bytes) -> None:
        """No output."""

    def take(self, topic: str, time_s: float) -> Fields | None:
        """The next of `topic`, if it is of `time_s` (s); those before are dropped."""
        waiting = self._waiting[topic]
        while waiting and waiting[0][0] < time_s:
            waiting.popleft()
        return waiting.popleft()[1] if waiting and waiting[0][0] == time_s else None
