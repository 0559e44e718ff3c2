"""How closely a simulated vehicle flies as the recorded one did, and how well the online learner foresees it.

Positions are compared at the instants of the setpoints. The twin flies without noise: an independent draw of
it would only add to the difference.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import joblib
import numpy as np

from companion.arrays import Times, Vec3, Vec3s
from companion.errors import InputError
from companion.experiments.prediction import Prediction, prediction_errors
from companion.experiments.twin import at_times, fly_twin
from companion.recording.excerpt import cut
from companion.recording.segments import Segment, Window
from companion.recording.series import Recording, rows
from sitl.vehicle import Vehicle

EXCITED_M = 0.05
"""An axis on which the positions sent span no more than this is not excited (m)."""
LONGEST_GAP_S = 1.0
"""Between two setpoints of one stretch; PX4 gives up waiting after as long (COM_OF_LOSS_T)."""
ARRIVED_M = 1.0
"""A vehicle that has come so near follows its setpoints."""
SHORTEST_S = 2.0
"""A segment of less says nothing."""

_MARGIN_S = 1.0
"""Of a recording on either side of a segment: what was sent, and where the vehicle was, as it began."""


@dataclass(frozen=True, eq=False)
class TwinFlight:
    """One segment as it was sent, as it was flown, and as the twin flies it (NED, m), at setpoint instants.

    Attributes:
        segment: which one.
        time_s: the instants (s, the recording's clock).
        sent: NaN where no position was sent.
        recorded, twin: positions.
    """

    segment: Segment
    time_s: Times
    sent: Vec3s
    recorded: Vec3s
    twin: Vec3s

    @property
    def tracking_errors(self) -> Vec3s:
        """Setpoint minus recorded position, a row for each instant at which a position was sent."""
        errors: Vec3s = (self.sent - self.recorded)[np.isfinite(self.sent).all(axis=1)]
        return errors

    @property
    def twin_errors(self) -> Vec3s:
        """The twin's minus the recorded position."""
        return self.twin - self.recorded

    @property
    def tracking_rms_m(self) -> float | None:
        """RMS distance of setpoint and recorded position; None where no position was sent."""
        return rms(self.tracking_errors) if len(self.tracking_errors) else None

    @property
    def twin_rms_m(self) -> float:
        """RMS distance of the twin's and the recorded position."""
        return rms(self.twin_errors)

    @property
    def ratio(self) -> float | None:
        """The twin's RMS over the tracking RMS."""
        tracking = self.tracking_rms_m
        return self.twin_rms_m / tracking if tracking else None

    @property
    def still_axes(self) -> list[int]:
        """The axes on which the positions sent stay where they are: 0 north, 1 east, 2 down."""
        sent = self.sent[np.isfinite(self.sent).all(axis=1)]
        return np.flatnonzero(np.ptp(sent, axis=0) <= EXCITED_M).tolist() if len(sent) else []


@dataclass(frozen=True, eq=False)
class SegmentFidelity:
    """What one segment shows: the twin's flight, and predictions by how far they look ahead (s).

    There are none where no position was sent.
    """

    flight: TwinFlight
    predictions: Mapping[float, Prediction]


@dataclass(frozen=True)
class PooledFidelity:
    """Mean squares for one axis (m²), over the instants of all segments and over all axes.

    Attributes:
        twin_m2: of the twin's minus the recorded position.
        tracking_m2: of the tracking error.
        wander_m2: variance of the tracking error about each segment's mean, on the axes that the segments do
            not excite: what no twin can foresee. None where every axis is excited.
    """

    twin_m2: float
    tracking_m2: float
    wander_m2: float | None

    @property
    def allowed_m2(self) -> float | None:
        """What `twin_m2` may be: 1.2 × the wander, and the square of a quarter of the tracking RMS."""
        return None if self.wander_m2 is None else 1.2 * self.wander_m2 + 0.25**2 * self.tracking_m2


def rms(errors: Vec3s) -> float:
    """Root mean square length of the rows."""
    return float(np.sqrt((errors**2).sum(axis=1).mean()))


def rms_axes(errors: Vec3s) -> Vec3:
    """Root mean square of each column."""
    axes: Vec3 = np.sqrt((errors**2).mean(axis=0))
    return axes


def pooled(flights: Sequence[TwinFlight]) -> PooledFidelity | None:
    """All segments of one recording together; None where no position was sent."""
    sent = [flight for flight in flights if len(flight.tracking_errors)]
    if not sent:
        return None
    wander = np.concatenate([_about_mean(each.tracking_errors)[:, each.still_axes].ravel() for each in sent])
    return PooledFidelity(
        twin_m2=float((np.concatenate([flight.twin_errors for flight in sent]) ** 2).mean()),
        tracking_m2=float((np.concatenate([flight.tracking_errors for flight in sent]) ** 2).mean()),
        wander_m2=float((wander**2).mean()) if wander.size else None,
    )


def _about_mean(errors: Vec3s) -> Vec3s:
    deviations: Vec3s = errors - errors.mean(axis=0)
    return deviations


def segments_of(recording: Recording) -> tuple[Segment, ...]:
    """The recording's segments; without any, each stretch in which setpoints came one after the other.

    Stretches begin where a trajectory was tracked, if the recording tells, else once the vehicle has come to
    where it was sent: before, it stood on the ground, or flew in another mode.

    Raises:
        InputError: nothing was sent for long enough.
    """
    if recording.segments:
        return recording.segments
    sent_s = _followed(recording)
    stretches = np.split(sent_s, np.flatnonzero(np.diff(sent_s) > LONGEST_GAP_S) + 1)
    windows = [
        Window(float(times[0]), float(times[-1]))
        for times in stretches
        if len(times) and times[-1] - times[0] >= SHORTEST_S
    ]
    if not windows:
        raise InputError(
            f"no {SHORTEST_S:g} s of setpoints that the vehicle followed: "
            "the log must hold what the companion sent (SET_POSITION_TARGET_LOCAL_NED), too"
        )
    return tuple(Segment(f"flight-{number}", window) for number, window in enumerate(windows, start=1))


def _followed(recording: Recording) -> Times:
    """When setpoints were sent that the vehicle followed (s)."""
    states, sent, tracking = recording.states, recording.references, recording.tracking
    if not len(states.time_s):
        return states.time_s
    sent = rows(sent, np.flatnonzero((sent.time_s > states.time_s[0]) & (sent.time_s < states.time_s[-1])))
    if tracking is not None and len(tracking.time_s):
        first_s, last_s = tracking.time_s[[0, -1]]
        tracked: Times = sent.time_s[(sent.time_s >= first_s) & (sent.time_s <= last_s)]
        return tracked
    distance = np.linalg.norm(sent.position - at_times(sent.time_s, states.time_s, states.position), axis=1)
    arrived = np.logical_or.accumulate(~(distance > ARRIVED_M))
    followed: Times = sent.time_s[arrived]
    return followed


def fly_segment(vehicle: Vehicle, recording: Recording, segment: Segment) -> TwinFlight:
    """The twin's flight of one segment beside the recorded one.

    Raises:
        InputError: no state or setpoint at the segment's start, or none within it.
    """
    window, sent, states = segment.window, recording.references, recording.states
    twin = fly_twin(vehicle, recording, window)
    last_s = min(window.end_s, states.time_s[-1])
    within = (sent.time_s >= window.start_s) & (sent.time_s <= last_s)
    if not within.any():
        raise InputError(f"segment {segment.id}: no setpoint was sent in it")
    time_s = sent.time_s[within]
    return TwinFlight(
        segment,
        time_s,
        sent.position[within],
        at_times(time_s, states.time_s, states.position),
        at_times(time_s, twin.time_s, twin.position),
    )


def evaluate(vehicle: Vehicle, recording: Recording, segment: Segment) -> SegmentFidelity:
    """One segment: the twin's flight, and the online learner's predictions without any simulator."""
    flight = fly_segment(vehicle, recording, segment)
    positions_sent = flight.tracking_rms_m is not None
    return SegmentFidelity(flight, prediction_errors(recording, segment) if positions_sent else {})


def evaluate_all(vehicle: Vehicle, recording: Recording) -> Iterator[SegmentFidelity]:
    """`evaluate` each segment on all cores; results come in the order of the segments.

    Raises:
        InputError: as of `segments_of` and `fly_segment`.
    """
    segments = segments_of(recording)
    workers = max(1, min(joblib.cpu_count(), len(segments)))
    with joblib.parallel_config("loky", inner_max_num_threads=1):
        parallel = joblib.Parallel(n_jobs=workers, batch_size=1, return_as="generator")
    results: Iterator[SegmentFidelity] = parallel(
        joblib.delayed(evaluate)(vehicle, _around(recording, segment), segment) for segment in segments
    )
    return results


def _around(recording: Recording, segment: Segment) -> Recording:
    """What one segment's evaluation needs of a recording: less to carry to another process."""
    return cut(recording, segment.window.start_s - _MARGIN_S, segment.window.end_s + _MARGIN_S)
