"""The one record schema, for data sets and flight logs: three time series and what they belong to.

States come at the telemetry's rate, references at the control rate, each with its own time, because that
is how they exist on a real vehicle. Everything is NED, metres, seconds, radians.
"""

import hashlib
from collections.abc import Mapping
from dataclasses import dataclass, field, fields
from typing import TypeAlias, TypeVar

import numpy as np
from pydantic import BaseModel, ConfigDict

from companion.arrays import Array, Times, Vec3s
from companion.recording.segments import Segment, Window

Indices: TypeAlias = np.ndarray[tuple[int, ...], np.dtype[np.intp]]


class Provenance(BaseModel):
    """What a recording is of: enough to fly it again."""

    model_config = ConfigDict(frozen=True, extra="allow")

    vehicle: str
    """Name of the vehicle, as in `config/vehicles/` where it is a simulated one."""
    trajectory: str = ""
    strategy: str = "baseline"
    software: str = ""
    conditions: str | None = None
    seed: int | None = None


@dataclass(frozen=True, eq=False)
class StateSeries:
    """What the autopilot estimated: `time_s` is when it held.

    The clock is the companion's in what we recorded ourselves, the vehicle's (`time_boot_ms` of its messages)
    in what was read from a flight log. All times of one recording are on one clock.
    """

    time_s: Times
    position: Vec3s
    velocity: Vec3s
    attitude: Vec3s
    rates: Vec3s


@dataclass(frozen=True, eq=False)
class ReferenceSeries:
    """What was sent to the autopilot, at the time of sending, or in a flight log of arrival; yaw in rad.

    NaN where a part was not sent.
    """

    time_s: Times
    position: Vec3s
    velocity: Vec3s
    acceleration: Vec3s
    yaw: Times


@dataclass(frozen=True, eq=False)
class TrackingSeries:
    """What the tracker wanted and thought, a row for each control step.

    Attributes:
        time_s: the recording's clock (s).
        desired_position, desired_velocity, desired_acceleration: the trajectory at that time.
        u1: position reference before the online correction (network or plain reference), m.
        u2: the online correction added to it, m.
        predicted_position: position that the online model expects one preview later, m; NaN without one.
        predicted_variance: its variance, m²; NaN without one.
        alpha: gain of the correction, a number an axis; NaN without one.
        network_share, correction_share: how much of a network and of the correction was flown (0 to 1); NaN
            where nobody judged (`learning.negative_transfer`).
    """

    time_s: Times
    desired_position: Vec3s
    desired_velocity: Vec3s
    desired_acceleration: Vec3s
    u1: Vec3s
    u2: Vec3s
    predicted_position: Vec3s
    predicted_variance: Vec3s
    alpha: Vec3s
    network_share: Times
    correction_share: Times


@dataclass(frozen=True, eq=False)
class Recording:
    """One flight, or one data set: states, references, and (where a trajectory was tracked) tracking.

    `events` are (time_s, text) pairs: the flight's states, STATUSTEXTs, what the guard did. `segments` are
    what was flown, in the order of time; `hover` is where the vehicle held one setpoint, and had settled.
    `made_by` is what else was told of it: the command, and the versions, by name. What was read from a file
    that was cut short is not `whole`.
    """

    provenance: Provenance
    states: StateSeries
    references: ReferenceSeries
    tracking: TrackingSeries | None = None
    events: tuple[tuple[float, str], ...] = field(default=())
    segments: tuple[Segment, ...] = ()
    hover: Window | None = None
    made_by: Mapping[str, str] = field(default_factory=dict)
    whole: bool = True


Series = TypeVar("Series", StateSeries, ReferenceSeries, TrackingSeries)


def rows(series: Series, chosen: Indices) -> Series:
    """The rows of `series` with these indices."""
    return type(series)(*(getattr(series, column.name)[chosen] for column in fields(series)))


def digest(recording: Recording) -> str:
    """SHA-256 (hex) of the recording's series: the same after a write and a read, whatever it is called."""
    sha = hashlib.sha256()
    for series in (recording.states, recording.references, recording.tracking):
        if series is None:
            continue
        for column in fields(series):
            values: Array = getattr(series, column.name)
            one_nan = np.where(np.isnan(values), np.nan, values)
            sha.update(f"{type(series).__name__}.{column.name} {values.shape}".encode())
            sha.update(np.ascontiguousarray(one_nan, dtype="<f8").tobytes())
    return sha.hexdigest()
