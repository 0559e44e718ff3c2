"""Estimator errors with which a twin wanders as a recorded vehicle did.

The recorded estimate holds the vehicle's true motion and the estimator's error, which the controller chases:
neither is seen alone. But hover is linear, so the power of the twin's estimate in each octave is the sum of
what each error process contributes, and that is simulated, one process at a time. Their levels are then those
whose sum comes closest to the recorded powers.

A hover is short: an error that is correlated over some seconds shows a draw or two of itself. But the drift,
the derivative of the estimated position less the estimated velocity, holds no true motion, so that it can be
measured in the whole flight, in as many windows as fit into it.
"""

from collections.abc import Iterable, Mapping, Sequence
from itertools import combinations, product
from typing import Any, Literal, NamedTuple, TypeAlias

import joblib
import numpy as np
from jaxtyping import Float
from scipy.optimize import nnls

from companion.arrays import Array, Vec3
from companion.experiments.wander import (
    OCTAVES_HZ,
    SHORTEST_HOVER_S,
    Moments,
    hover_of,
    recorded_wander,
    simulated_wander,
    wander_of,
)
from companion.recording.excerpt import cut
from companion.recording.segments import Segment
from companion.recording.series import Recording, StateSeries
from sitl.estimator_errors import EstimatorErrors
from sitl.vehicle import Vehicle

SIMULATED_WINDOWS = 12
"""For each process."""

Quantity: TypeAlias = Literal["position", "velocity", "attitude"]

_LEVEL_UNITS: dict[Quantity, str] = {"position": "m", "velocity": "m_s", "attitude": "deg"}
_CORRELATION_TIMES_S = (0.1, 0.3, 1.0, 4.0, 10.0)
"""Of the processes to choose from; a slower one could not be told from an offset in so short a hover."""
_MEASURE_WEIGHTS = np.array((1.0, 0.02, 0.02, 0.05))
"""Of position, velocity, attitude and drift in the fit: the position is what shows, and the drift tells
the velocity's error from a true motion."""
_DRIFT = 3
_LIKELY = 3.0
"""So many times the hover's power may a flight's drift have; with more, in most octaves, it is of moving."""
_MOMENT_WEIGHTS = np.array((*np.ones(len(OCTAVES_HZ)), 8.0))
"""Of each octave, and of the variance."""
_REWEIGHTINGS = 4
_LEAST_SHARE = 1e-3
"""Of a recorded power: less counts as this much, so that no single octave decides."""

_NOTHING = 1e-15
"""In place of a moment of 0, which a simulated hover has, so that ratios exist."""


class _Process(NamedTuple):
    """A first-order Gauss-Markov error of one quantity."""

    quantity: Quantity
    correlation_time_s: float


_UNIT_RATES = np.radians(1.0)
_UNIT_LEVELS: dict[Quantity, float] = {"position": 0.05, "velocity": 0.05, "attitude": 0.3}
"""At which each process is tried: small enough for the loop to stay linear (m, m/s, degrees)."""


def fit_estimator_errors(
    vehicle: Vehicle,
    recording: Recording,
    segments: Sequence[Segment],
    *,
    windows: int = SIMULATED_WINDOWS,
    seed: int = 0,
) -> EstimatorErrors:
    """The errors of position, velocity, attitude and rates with which the vehicle wanders as recorded.

    Args:
        vehicle: the twin, whose delays stay.
        recording: with a hover window.
        segments: in order of time; from the first one's start to the last one's end the drift is measured.
        windows: of the hover's length, how many are simulated for each process.
        seed: of the simulated errors.

    Raises:
        InputError: the recording has no hover, or one too short.
    """
    hovering = np.maximum(recorded_wander(recording).moments, _NOTHING)
    hover = recording.hover
    assert hover is not None
    window_s = hover.end_s - hover.start_s
    wanted, weights = wanted_moments(hovering, recording.states, segments, window_s)
    processes = [_Process(quantity, time_s) for quantity in _LEVEL_UNITS for time_s in _CORRELATION_TIMES_S]
    responses: list[Moments] = joblib.Parallel(n_jobs=-1)(
        joblib.delayed(_response)(vehicle, process, window_s, windows, seed) for process in processes
    )
    pairs, levels = _closest(wanted, weights, dict(zip(processes, responses, strict=True)))
    shaken = _shaking(cut(recording, hover.start_s, hover.end_s).states)
    unit = EstimatorErrors.model_validate({"rates": {"noise_deg_s": np.degrees(_UNIT_RATES)}})
    rates = _UNIT_RATES * shaken / _shaking(hover_of(vehicle, unit, SHORTEST_HOVER_S, seed))
    return _errors(pairs, levels, vehicle.estimator or EstimatorErrors(), rates)


_AXES: Sequence[Sequence[tuple[int, int]]] = (
    ((0, 0), (1, 0), (2, 1), (3, 0)),
    ((0, 1), (1, 1), (2, 0), (3, 1)),
    ((0, 2), (1, 2), (3, 2)),
    ((2, 2),),
)
"""What acts on each other in hover, (measure, axis): north and pitch, east and roll, down, heading."""


class _Pair(NamedTuple):
    """The two processes of one quantity: a faster one, its noise, and a slower one, its wander."""

    noise: _Process
    wander: _Process


class Wanted(NamedTuple):
    """Moments to come close to, and how much each measure counts."""

    moments: Moments
    weights: Float[Array, " 4"]


def wanted_moments(
    hovering: Moments, states: StateSeries, segments: Sequence[Segment], window_s: float
) -> Wanted:
    """The hover's moments, but for the drift: that of the flight from the first segment to the last.

    A mean over n windows is n times as certain, and counts for as much. Where a flight drifts more than a
    hover ever might, delays or scales do it, and the hover's own drift stays.
    """
    moments, weights = hovering.copy(), _MEASURE_WEIGHTS.copy()
    ends_s = (segments[0].window.start_s, segments[-1].window.end_s) if segments else (0.0, 0.0)
    starts_s = np.arange(ends_s[0], ends_s[1] - window_s, window_s).tolist()
    if starts_s:
        flown = wander_of(states, starts_s, window_s).moments[_DRIFT]
        if np.mean(flown < _LIKELY * hovering[_DRIFT]) > 0.5:
            moments[_DRIFT] = flown
            weights[_DRIFT] *= len(starts_s)
    return Wanted(moments, weights)


def _response(vehicle: Vehicle, process: _Process, window_s: float, windows: int, seed: int) -> Moments:
    """Moments of the estimate under one process alone, for a level of 1 (m, m/s, rad) on every axis."""
    level = _UNIT_LEVELS[process.quantity]
    errors = EstimatorErrors.model_validate(
        {
            process.quantity: {
                f"noise_{_LEVEL_UNITS[process.quantity]}": level,
                "correlation_time_s": process.correlation_time_s,
            }
        }
    )
    level_si = np.radians(level) if process.quantity == "attitude" else level
    return simulated_wander(vehicle, errors, window_s, windows=windows, seed=seed).moments / level_si**2


def _closest(
    recorded: Moments, weights: Float[Array, " 4"], responses: Mapping[_Process, Moments]
) -> tuple[Sequence[_Pair], Float[Array, "3 2 3"]]:
    """For each quantity the pair that serves best to come close to the recorded powers, and the levels.

    Levels are by quantity, process (noise, wander) and axis.
    """
    choices = product(
        *([_Pair(*two) for two in combinations(_of(quantity, responses), 2)] for quantity in _LEVEL_UNITS)
    )
    best: tuple[float, Sequence[_Pair], Float[Array, "3 2 3"]] = (np.inf, (), np.zeros((3, 2, 3)))
    for pairs in choices:
        variances, misfit = np.zeros((3, 2, 3)), 0.0
        for axes in _AXES:
            rows = tuple(np.transpose(axes))
            erring = [(measure, axis) for measure, axis in axes if measure < len(pairs)]
            model = np.column_stack(
                [responses[process][rows].ravel() for quantity, _ in erring for process in pairs[quantity]]
            )
            weight = np.outer(weights[list(rows[0])], _MOMENT_WEIGHTS).ravel()
            solution, distance = _non_negative(model, recorded[rows].ravel(), weight)
            for (quantity, axis), two in zip(erring, solution.reshape(-1, 2), strict=True):
                variances[quantity, :, axis] = two
            misfit += distance
        if misfit < best[0]:
            best = misfit, pairs, np.sqrt(variances)
    return best[1:]


def _of(quantity: Quantity, processes: Iterable[_Process]) -> list[_Process]:
    return [process for process in processes if process.quantity == quantity]


def _non_negative(
    model: Float[Array, "rows columns"], wanted: Float[Array, " rows"], weight: Float[Array, " rows"]
) -> tuple[Float[Array, " columns"], float]:
    """Non-negative x with `model` x close to `wanted` in the ratio, and the weighted squares of its log.

    Least squares of the ratio shuns too much more than too little; dividing by the geometric mean of both
    sides instead makes it, step by step, that of the logarithm.
    """
    scale = wanted
    for _ in range(_REWEIGHTINGS):
        rows = np.sqrt(weight) / scale
        unscaled = model * rows[:, None]
        sizes = np.linalg.norm(unscaled, axis=0)
        x = nnls(unscaled / sizes, wanted * rows)[0] / sizes
        scale = np.sqrt(np.maximum(model @ x, _LEAST_SHARE * wanted) * wanted)
    logs = np.log(np.maximum(model @ x, _LEAST_SHARE * wanted) / wanted)
    return x, float(weight @ logs**2)


def _errors(
    pairs: Sequence[_Pair], levels: Float[Array, "3 2 3"], known: EstimatorErrors, rates: Vec3
) -> EstimatorErrors:
    """The errors with these levels; what hover does not tell is as `known`."""
    fitted: dict[str, Any] = {}
    for (quantity, unit), pair, (noise, wander) in zip(_LEVEL_UNITS.items(), pairs, levels, strict=True):
        per_unit = np.degrees(1.0) if quantity == "attitude" else 1.0
        fitted[quantity] = {
            f"noise_{unit}": _rounded(per_unit * noise),
            "correlation_time_s": pair.noise.correlation_time_s,
            f"wander_{unit}": _rounded(per_unit * wander),
            "wander_time_s": pair.wander.correlation_time_s,
            "delay_s": getattr(known, quantity).delay_s,
        }
    fitted["rates"] = {"noise_deg_s": _rounded(np.degrees(rates)), "delay_s": known.rates.delay_s}
    return EstimatorErrors.model_validate(fitted | {"resets_per_hour": known.resets_per_hour})


def _shaking(states: StateSeries) -> Vec3:
    """How much the body rates change from one state to the next, which noise does most (rad/s, RMS)."""
    change: Vec3 = np.diff(states.rates, axis=0).std(axis=0)
    return change


def _rounded(levels: Vec3) -> tuple[float, ...]:
    """To three significant digits, which is more than a short hover tells."""
    return tuple(float(f"{level:.3g}") for level in levels)
