"""Numbers of a vehicle file from a flight of that vehicle: those with which its twin flies as it did.

Bounded least squares over the twin's distance from the recording in position and velocity. The twin is put
back onto the recorded state every few seconds (multiple shooting), so that no gust decides.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TypeAlias

import joblib
import numpy as np
from jaxtyping import Float
from scipy.optimize import least_squares

from companion.arrays import Array, Times
from companion.errors import InputError
from companion.experiments.confidence import confidence_half_widths
from companion.experiments.twin import at_times, fly_twin
from companion.experiments.vehicle_parameters import Parameter, with_values
from companion.recording.excerpt import cut
from companion.recording.segments import Segment, Window
from companion.recording.series import Recording, StateSeries
from sitl.vehicle import Vehicle

SHOT_S = 15.0
"""About how long the twin flies between two recorded states."""
LEAD_IN_S = 5.0
"""Flown before it counts: what a recorded state does not tell, integrals and rotor speeds, has come about."""
SHORTEST_S = LEAD_IN_S + 2.0
"""The shortest segment that says something."""
SAMPLE_S = 0.05
"""Between two instants that are compared."""
VELOCITY_WEIGHT_S = 0.5
"""A difference of 1 m/s counts as one of so many metres."""

_STEP = 0.005
"""Of finite differences, in widths of a parameter's bounds."""
_TOLERANCE = 1e-4
_MOST_TRIALS = 25
_AT_BOUND = 1e-3
_WIDE = 0.25
"""An interval of more than this share of the bounds' width, to either side, tells nothing."""

Units: TypeAlias = Float[Array, " k"]
Residuals: TypeAlias = Float[Array, "samples 6"]
Report: TypeAlias = Callable[[int, float], None]
"""Told before each iteration: its number, and the RMS distance in position so far (m)."""


@dataclass(frozen=True, eq=False)
class Shot:
    """A stretch of a recording that the twin flies in one go, and from when on it counts (s)."""

    recording: Recording
    window: Window
    counted_from_s: float


@dataclass(frozen=True)
class Estimated:
    """One parameter as it was found.

    Attributes:
        parameter: which, with its start and its bounds.
        value: found.
        half_width: of the 95 % confidence interval; infinite where the flight does not show it at all.
    """

    parameter: Parameter
    value: float
    half_width: float

    @property
    def at_bound(self) -> bool:
        """Whether it would be further off if it were allowed to."""
        margin = _AT_BOUND * (self.parameter.high - self.parameter.low)
        return not self.parameter.low + margin < self.value < self.parameter.high - margin

    @property
    def identifiable(self) -> bool:
        """Whether the flight tells it apart from other values within the bounds."""
        return self.half_width < _WIDE * (self.parameter.high - self.parameter.low)


@dataclass(frozen=True, eq=False)
class Identification:
    """What came of a fit.

    Attributes:
        vehicle: with the values found.
        estimates: a parameter each, in the order asked for.
        start_rms_m, rms_m: RMS distance of twin and recording in position, before and after (m).
        shots: how many stretches were flown in each evaluation.
        converged: whether the fit came to an end by itself.
    """

    vehicle: Vehicle
    estimates: tuple[Estimated, ...]
    start_rms_m: float
    rms_m: float
    shots: int
    converged: bool


def shots_of(recording: Recording, segments: Sequence[Segment]) -> list[Shot]:
    """The segments in stretches of about `SHOT_S`, each with its lead-in before it.

    Raises:
        InputError: a segment is too short.
    """
    shots = []
    for segment in segments:
        start_s, end_s = segment.window.start_s, segment.window.end_s
        if end_s - start_s < SHORTEST_S:
            raise InputError(
                f"segment {segment.id} lasts {end_s - start_s:.1f} s, of which the first {LEAD_IN_S:g} s do "
                f"not count; {SHORTEST_S:g} s are the least: choose others"
            )
        counted_s = end_s - start_s - LEAD_IN_S
        edges = np.linspace(start_s + LEAD_IN_S, end_s, max(1, round(counted_s / SHOT_S)) + 1)
        for first_s, last_s in zip(edges[:-1].tolist(), edges[1:].tolist(), strict=True):
            window = Window(first_s - LEAD_IN_S, last_s)
            part = cut(recording, window.start_s - 1.0, window.end_s + 1.0)
            shots.append(Shot(part, window, first_s))
    return shots


def identify(
    vehicle: Vehicle, shots: Sequence[Shot], parameters: Sequence[Parameter], report: Report
) -> Identification:
    """Fit the parameters, on all cores; the same input gives the same values.

    Trials that no vehicle file may hold, or in which the twin comes to nothing finite, are not followed.

    Raises:
        InputError: there is nothing to fit, nothing that shows in the shots, the vehicle does not fly as it
            is, or no state or setpoint was recorded at the start of a shot.
    """
    if not parameters or not shots:
        raise InputError("nothing to fit: name at least one parameter and one segment")
    problem = _Problem(vehicle, shots, parameters, report)
    start_rms_m = _rms_m(_fly([vehicle], shots)[0])
    if not np.isfinite(start_rms_m):
        raise InputError(f"{vehicle.name} cannot fly these setpoints as its file is: correct it first")
    found = least_squares(
        problem.residuals,
        problem.start,
        jac=problem.jacobian,
        bounds=(0.0, 1.0),
        ftol=_TOLERANCE,
        xtol=_TOLERANCE,
        gtol=None,
        max_nfev=_MOST_TRIALS,
    )
    fitted = problem.trial(found.x)
    assert fitted is not None, "what was not valid was not followed"
    residuals = found.fun.reshape(-1, 6)
    jacobian = np.asarray(found.jac).reshape(-1, 6, len(parameters))
    lengths = [len(_instants(shot)) for shot in shots]
    half_widths = problem.width * confidence_half_widths(jacobian, residuals, lengths)
    return Identification(
        vehicle=fitted,
        estimates=tuple(
            Estimated(parameter, value, half_width)
            for parameter, value, half_width in zip(
                parameters,
                problem.values(found.x),
                half_widths.tolist(),
                strict=True,
            )
        ),
        start_rms_m=start_rms_m,
        rms_m=_rms_m(residuals),
        shots=len(shots),
        converged=found.status > 0,
    )


class _Problem:
    """The least-squares problem, each parameter counted from 0 to 1 between its bounds."""

    def __init__(
        self, vehicle: Vehicle, shots: Sequence[Shot], parameters: Sequence[Parameter], report: Report
    ) -> None:
        self._vehicle = vehicle
        self._shots = shots
        self._report = report
        self._keys = [each.key for each in parameters]
        self._low = np.array([each.low for each in parameters])
        self._iterations = 0
        self.width = np.array([each.high for each in parameters]) - self._low
        self.start = (np.array([each.start for each in parameters]) - self._low) / self.width

    def values(self, unit: Units) -> list[float]:
        """In the units of the file."""
        values: list[float] = (self._low + self.width * unit).tolist()
        return values

    def trial(self, unit: Units) -> Vehicle | None:
        """The vehicle with these values; None where no vehicle file may say so."""
        try:
            return with_values(self._vehicle, dict(zip(self._keys, self.values(unit), strict=True)))
        except InputError:
            return None

    def residuals(self, unit: Units) -> Float[Array, " n"]:
        """The twin's distances, not finite for a trial that is none."""
        return _fly([self.trial(unit)], self._shots)[0].ravel()

    def jacobian(self, unit: Units) -> Float[Array, "n k"]:
        """By finite differences; a parameter that cannot move either way has no effect."""
        steps = [self._step(unit, number) for number in range(len(unit))]
        trials = [self.trial(unit), *(self.trial(unit + step) for step in steps)]
        here, *stepped = _fly(trials, self._shots)
        self._iterations += 1
        self._report(self._iterations, _rms_m(here))
        columns = [(there - here).ravel() / step.sum() for there, step in zip(stepped, steps, strict=True)]
        matrix: Float[Array, "n k"] = np.nan_to_num(np.column_stack(columns))
        if not matrix.any():
            raise InputError(f"nothing of {', '.join(self._keys)} shows in these segments: choose others")
        return matrix

    def _step(self, unit: Units, number: int) -> Units:
        step = np.zeros_like(unit)
        step[number] = _STEP
        is_open = unit[number] + _STEP <= 1.0 and self.trial(unit + step) is not None
        return step if is_open else -step


def _fly(trials: Sequence[Vehicle | None], shots: Sequence[Shot]) -> list[Residuals]:
    """Residuals of each trial over all shots."""
    workers = max(1, min(joblib.cpu_count(), len(trials) * len(shots)))
    with joblib.parallel_config("loky", inner_max_num_threads=1):
        flown = joblib.Parallel(n_jobs=workers)(
            joblib.delayed(_residuals)(trial, shot) for trial in trials for shot in shots
        )
    return [np.concatenate(flown[i : i + len(shots)]) for i in range(0, len(flown), len(shots))]


def _residuals(trial: Vehicle | None, shot: Shot) -> Residuals:
    """Twin minus recording: position (m), and weighted velocity (m)."""
    time_s = _instants(shot)
    if trial is None:
        return np.full((len(time_s), 6), np.nan)
    twin = fly_twin(trial, shot.recording, shot.window)
    difference: Residuals = _position_and_velocity(twin, time_s) - _position_and_velocity(
        shot.recording.states, time_s
    )
    difference[:, 3:] *= VELOCITY_WEIGHT_S
    return difference


def _instants(shot: Shot) -> Times:
    return np.arange(shot.counted_from_s, shot.window.end_s, SAMPLE_S)


def _position_and_velocity(states: StateSeries, time_s: Times) -> Float[Array, "samples 6"]:
    return at_times(time_s, states.time_s, np.column_stack((states.position, states.velocity)))


def _rms_m(residuals: Residuals) -> float:
    """RMS distance in position (m)."""
    return float(np.sqrt((residuals[:, :3] ** 2).sum(axis=1).mean()))
