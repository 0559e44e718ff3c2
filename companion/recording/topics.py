"""What a recording's messages are called and what is in them: one table for writers, readers and viewers.

A message is a JSON object with `time_s`, the recording's clock to the last bit. A vector is an object, too
(`position.x`), so that a viewer names its curves by itself. NaN, which JSON does not have, is a component
left out; viewers that follow the schema refuse `null`.

`/state`, `/reference` and `/tracking` are the series of `companion.recording.series`, a message a row; a
message may have more than the row. `/events` is of a schema that Foxglove knows (`companion.recording.scene`
has the others).
"""

import dataclasses
import math
from collections.abc import Iterable, Mapping
from enum import IntEnum
from typing import Any, TypeAlias

import numpy as np

from companion.arrays import Array
from companion.recording import scene
from companion.recording.series import ReferenceSeries, StateSeries, TrackingSeries

Fields: TypeAlias = dict[str, Any]
"""What a message says besides its time."""
Row: TypeAlias = Mapping[str, Array | float | None]
"""Numbers and vectors by name; None where there is none."""
Schema: TypeAlias = dict[str, Any]

STATE, REFERENCE, TRACKING = "/state", "/reference", "/tracking"
EVENTS, GUARD, PARAMETERS = "/events", "/guard", "/parameters"
CONTROL, TRAJECTORY = "/control", "/trajectory"

SERIES = {STATE: StateSeries, REFERENCE: ReferenceSeries, TRACKING: TrackingSeries}

XYZ = ("x", "y", "z")
_NOT_XYZ = {
    "attitude": ("roll", "pitch", "yaw"),
    "rates": ("p", "q", "r"),
    **dict.fromkeys(("yaw", "network_share", "correction_share"), ()),
}
"""Columns whose components have names of their own, or that are mere numbers and have none."""


def _columns(kind: type[StateSeries | ReferenceSeries | TrackingSeries]) -> dict[str, tuple[str, ...]]:
    """Names of a series' columns, in order, with the names of their components."""
    names = [field.name for field in dataclasses.fields(kind)]
    return {name: _NOT_XYZ.get(name, XYZ) for name in names if name != "time_s"}


COLUMNS = {topic: _columns(kind) for topic, kind in SERIES.items()}

NUMBERS: dict[str, dict[str, tuple[str, ...]]] = {
    STATE: COLUMNS[STATE] | {"received_s": ()},
    REFERENCE: COLUMNS[REFERENCE],
    TRACKING: COLUMNS[TRACKING]
    | dict.fromkeys(("u1_velocity", "u1_acceleration", "u2_velocity", "loop_gain"), XYZ),
    GUARD: {"moved": XYZ},
    PARAMETERS: {"value": ()},
    TRAJECTORY: dict.fromkeys(("start_s", "duration_s", "step_s"), ()),
}
"""The numbers and vectors of each topic's messages."""
TEXTS = {
    EVENTS: ("name", "message", "data"),
    GUARD: ("clips",),
    PARAMETERS: ("name",),
    CONTROL: ("settings",),
    TRAJECTORY: ("name", "law", "attachment"),
}
SCHEMA_NAMES = {EVENTS: "foxglove.Log", **scene.SCHEMA_NAMES}
"""Where a viewer knows the schema by its name; the others are ours."""
OLD_EVENTS = "impromptu.Events"
"""The schema of events in recordings of before they were shown as a log: `time_s` and `text`."""
TOPICS = (*SERIES, EVENTS, GUARD, PARAMETERS, CONTROL, TRAJECTORY, *scene.SCHEMA_NAMES)

PROVENANCE, SEGMENTS, VERSIONS, TECHNIQUE = "provenance", "segments", "versions", "technique"
CONFIGURATION = "configuration"
METADATA = (PROVENANCE, SEGMENTS, VERSIONS, TECHNIQUE, CONFIGURATION)
"""What is known once, each a set of names and values."""


class Level(IntEnum):
    """How grave an event is: the `level` of a `foxglove.Log`."""

    INFO = 2
    WARNING = 3
    ERROR = 4


def row(topic: str, values: Row) -> Fields:
    """Numbers and vectors as a message of `topic`, without what is None or not finite."""
    fields: Fields = {}
    for name, value in values.items():
        components = NUMBERS[topic][name]
        if components:
            fields[name] = {} if value is None else _finite(components, np.asarray(value).tolist())
        elif value is not None:
            fields |= _finite((name,), (float(value),))
    return fields


def event(unix_ns: int, text: str, kind: str = "", data: str = "", level: Level = Level.INFO) -> Fields:
    """An event as a `foxglove.Log`; `kind` is for programs, `data` is JSON."""
    return {
        "timestamp": scene.timestamp(unix_ns),
        "level": level,
        "name": kind,
        "message": text,
        "data": data,
    }


def _finite(names: Iterable[str], numbers: Iterable[float]) -> dict[str, float]:
    return {name: number for name, number in zip(names, numbers, strict=True) if math.isfinite(number)}


def schema_name(topic: str) -> str:
    """The name of a topic's schema."""
    return SCHEMA_NAMES.get(topic, f"impromptu.{topic.removeprefix('/').capitalize()}")


def json_schema(topic: str) -> Schema:
    """The JSON schema of a topic's messages."""
    vectors = NUMBERS.get(topic, {})
    properties: Schema = {"time_s": scene.NUMBER}
    for name, parts in vectors.items():
        properties[name] = scene.record(dict.fromkeys(parts, scene.NUMBER)) if parts else scene.NUMBER
    properties |= dict.fromkeys(TEXTS.get(topic, ()), scene.TEXT)
    properties |= scene.PROPERTIES.get(topic, {})
    if topic == EVENTS:
        properties |= {"timestamp": scene.TIMESTAMP, "level": scene.INTEGER}
    return scene.record(properties) | {
        "title": schema_name(topic),
        "description": "NED, metres, seconds, radians; time_s is the recording's clock",
        "required": ["time_s", *(name for name, parts in vectors.items() if parts)],
    }
