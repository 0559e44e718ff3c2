"""What a control loop was told and saw, and what it made of it, from the file that was written meanwhile."""

import math
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import TypeAlias

import numpy as np

from companion.arrays import Vec3
from companion.errors import InputError
from companion.flight.control import ControlSettings
from companion.flight.technique import Technique
from companion.recording.mcap_reader import (
    UNREADABLE,
    Attachment,
    CutShort,
    Item,
    Message,
    Metadata,
    read_items,
)
from companion.recording.topics import (
    CONTROL,
    GUARD,
    NUMBERS,
    REFERENCE,
    STATE,
    TECHNIQUE,
    TRACKING,
    TRAJECTORY,
    Fields,
)
from companion.state import VehicleState
from companion.trajectory.trajectory import Trajectory

OUTPUTS = (REFERENCE, TRACKING, GUARD)


@dataclass(frozen=True, eq=False)
class Began:
    """The control loop began at `time_s` (companion clock, s)."""

    time_s: float
    settings: ControlSettings


@dataclass(frozen=True, eq=False)
class Followed:
    """From `time_s` on this was tracked (companion clock, s), by the law of that name (`Tracker`)."""

    time_s: float
    trajectory: Trajectory
    start_s: float
    law: str


Input: TypeAlias = Technique | Began | Followed | VehicleState | Message | CutShort
"""A `Message` is an output: one of `OUTPUTS`."""


def recorded_inputs(path: Path) -> Iterator[Input]:
    """Inputs and outputs, in the order in which they came.

    Raises:
        InputError: the file cannot be read, is damaged, or no MCAP file.
    """
    attachments: dict[str, bytes] = {}
    for item in read_items(path):
        if isinstance(item, Attachment):
            attachments[item.name] = item.data
            continue
        try:
            found = _input(item, attachments)
        except UNREADABLE as error:
            why = " ".join(str(error).split())
            raise InputError(
                f"{path}: damaged, or of another version: no input of a control loop ({why})"
            ) from error
        if found is not None:
            yield found


def _input(item: Item, attachments: dict[str, bytes]) -> Input | None:
    match item:
        case CutShort():
            return item
        case Metadata(name, values) if name == TECHNIQUE:
            return Technique.model_validate(values)
        case Message(topic) if topic in OUTPUTS:
            return item
        case Message(topic, time_s, fields) if topic == STATE:
            return _state(time_s, fields)
        case Message(topic, time_s, fields) if topic == CONTROL:
            return Began(time_s, ControlSettings.model_validate_json(fields["settings"]))
        case Message(topic, time_s, fields) if topic == TRAJECTORY:
            trajectory = _trajectory(fields, attachments.pop(fields["attachment"]))
            return Followed(time_s, trajectory, float(fields["start_s"]), fields["law"])
    return None


def _trajectory(fields: Fields, data: bytes) -> Trajectory:
    coefficients = np.frombuffer(data, dtype="<f8").astype(np.float64).reshape(-1, 6, 3)
    step_s = float(fields["step_s"])
    if not (len(coefficients) and np.isfinite(coefficients).all() and 0.0 < step_s < math.inf):
        raise ValueError("no trajectory")
    return Trajectory(str(fields["name"]), step_s, coefficients)


def _state(time_s: float, fields: Fields) -> VehicleState:
    def vector(name: str) -> Vec3:
        return np.array([fields[name][part] for part in NUMBERS[STATE][name]], dtype=np.float64)

    return VehicleState(
        time_s=time_s,
        received_s=float(fields.get("received_s", time_s)),
        position=vector("position"),
        velocity=vector("velocity"),
        attitude=vector("attitude"),
        rates=vector("rates"),
    )
