"""How an autopilot's estimate wanders in hover, and the estimator errors that make a twin wander alike.

The recorded estimate holds the vehicle's true motion and the estimator's error, which the controller chases:
neither is seen alone. But hover is linear, so the power of the twin's estimate in each octave is the sum of
what each error process contributes, and that is simulated, one process at a time. Their levels are then those
whose sum comes closest to the recorded powers.
"""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations, product
from typing import Any, Literal, NamedTuple, TypeAlias

import joblib
import numpy as np
from jaxtyping import Float
from scipy.optimize import nnls
from scipy.signal import periodogram
from scipy.spatial.transform import Rotation

from companion.arrays import Array, Times, Vec3, Vec3s
from companion.errors import InputError
from companion.experiments.twin import state_series
from companion.recording.excerpt import cut
from companion.recording.series import Recording, StateSeries
from sitl.conditions import Conditions
from sitl.estimator_errors import EstimatorErrors
from sitl.firmware.interface import Setpoint
from sitl.plant import TICK_S
from sitl.simulation import Simulation
from sitl.vehicle import Vehicle

OCTAVES_HZ = ((0.05, 0.1), (0.1, 0.2), (0.2, 0.4), (0.4, 0.8), (0.8, 1.6), (1.6, 2.0))
"""From 0.05 to 2 Hz; the last one is cut."""
RATE_HZ = 50.0
"""At which powers are taken."""
SHORTEST_HOVER_S = 10.0
"""A window of less says nothing of the lower octaves."""

_UNIT_RATES = np.radians(1.0)
_IN_HOVER = np.array((0.0, 0.0, -100.0, *np.zeros(3), 1.0, *np.zeros(6)))
_SETTLING_S = 20.0
SIMULATED_WINDOWS = 12
"""For each process in a fit."""
COMPARED_WINDOWS = 48
"""Of a twin beside its recording: with 12, chance alone moved a standard deviation by a third."""

Quantity: TypeAlias = Literal["position", "velocity", "attitude"]
Moments: TypeAlias = Float[Array, "4 3 moments"]

_LEVEL_UNITS: dict[Quantity, str] = {"position": "m", "velocity": "m_s", "attitude": "deg"}
_CORRELATION_TIMES_S = (0.1, 0.3, 1.0, 4.0, 10.0)
"""Of the processes to choose from; a slower one could not be told from an offset in so short a hover."""
_MEASURE_WEIGHTS = np.array((1.0, 0.02, 0.02, 0.05))
"""Of position, velocity, attitude and drift in the fit: the position is what shows, and the drift tells
the velocity's error from a true motion."""
_MOMENT_WEIGHTS = np.array((*np.ones(len(OCTAVES_HZ)), 8.0))
"""Of each octave, and of the variance."""
_REWEIGHTINGS = 4
_LEAST_SHARE = 1e-3
"""Of a recorded power: less counts as this much, so that no single octave decides."""


class _Process(NamedTuple):
    """A first-order Gauss-Markov error of one quantity."""

    quantity: Quantity
    correlation_time_s: float


_UNIT_LEVELS: dict[Quantity, float] = {"position": 0.05, "velocity": 0.05, "attitude": 0.3}
"""At which each process is tried: small enough for the loop to stay linear (m, m/s, degrees)."""


@dataclass(frozen=True, eq=False)
class Wander:
    """How an estimate moves about in hover.

    Both by measure, position (m²), velocity (m²/s²), attitude (rad²), drift (m²/s²), and axis: north, east,
    down, or roll, pitch, yaw. The drift is by how much the position moves faster than the velocity says.

    Attributes:
        variance: of all that moves within a window.
        powers: in each of `OCTAVES_HZ`.
    """

    variance: Float[Array, "4 3"]
    powers: Float[Array, "4 3 octaves"]

    @property
    def deviation_m(self) -> Vec3:
        """Standard deviation of the position, north, east, down (m)."""
        deviation: Vec3 = np.sqrt(self.variance[0])
        return deviation

    @property
    def moments(self) -> "Moments":
        """Powers, and last the variance."""
        return np.concatenate((self.powers, self.variance[..., None]), axis=-1)


def recorded_wander(recording: Recording) -> Wander:
    """In the recording's hover window.

    Raises:
        InputError: there is none, or it is too short.
    """
    window = recording.hover
    if window is None or window.end_s - window.start_s < SHORTEST_HOVER_S:
        raise InputError(
            f"the recording has no hover of {SHORTEST_HOVER_S:g} s: let the vehicle hold a setpoint for as "
            "long, and name the time in the card beside the log"
        )
    return _windows(recording.states, [window.start_s], window.end_s - window.start_s)


def simulated_wander(
    vehicle: Vehicle,
    errors: EstimatorErrors,
    window_s: float,
    *,
    windows: int = SIMULATED_WINDOWS,
    seed: int = 0,
) -> Wander:
    """In hover under these errors, the mean over windows of `window_s` (s), one after another."""
    states = hover_of(vehicle, errors, _SETTLING_S + windows * window_s, seed)
    return _windows(states, _SETTLING_S + window_s * np.arange(windows), window_s)


class WanderComparison(NamedTuple):
    """How a twin wanders in hover and how the recorded vehicle did, of one window's length."""

    twin: Wander
    recorded: Wander


def compare_wander(vehicle: Vehicle, recording: Recording) -> WanderComparison | None:
    """In hover under the vehicle's own errors; None where it has none, or the recording no hover."""
    hover = recording.hover
    if vehicle.estimator is None or hover is None or hover.end_s - hover.start_s < SHORTEST_HOVER_S:
        return None
    window_s = hover.end_s - hover.start_s
    twin = simulated_wander(vehicle, vehicle.estimator, window_s, windows=COMPARED_WINDOWS)
    return WanderComparison(twin, recorded_wander(recording))


def fit_estimator_errors(
    vehicle: Vehicle, recording: Recording, *, windows: int = SIMULATED_WINDOWS, seed: int = 0
) -> EstimatorErrors:
    """The errors of position, velocity, attitude and rates with which the vehicle wanders as recorded.

    Raises:
        InputError: the recording has no hover, or one too short.
    """
    recorded = recorded_wander(recording)
    hover = recording.hover
    assert hover is not None
    processes = [_Process(quantity, time_s) for quantity in _LEVEL_UNITS for time_s in _CORRELATION_TIMES_S]
    responses: list[Moments] = joblib.Parallel(n_jobs=-1)(
        joblib.delayed(_response)(vehicle, process, hover.end_s - hover.start_s, windows, seed)
        for process in processes
    )
    pairs, levels = _closest(recorded.moments, dict(zip(processes, responses, strict=True)))
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
    recorded: Moments, responses: Mapping[_Process, Moments]
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
            weight = np.outer(_MEASURE_WEIGHTS[list(rows[0])], _MOMENT_WEIGHTS).ravel()
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
        x, _residual = nnls(model * rows[:, None], wanted * rows)
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


def hover_of(vehicle: Vehicle, errors: EstimatorErrors, duration_s: float, seed: int) -> StateSeries:
    """The estimate of a vehicle that holds one setpoint, heading north, every 10 ms."""
    simulation = Simulation(vehicle, Conditions(name="hover", estimator=errors), seed=seed, motion=_IN_HOVER)
    firmware = simulation.firmware
    held = Setpoint(position=_IN_HOVER[:3], velocity=np.zeros(3), yaw=0.0)
    estimates = []
    for tick in range(round(duration_s / TICK_S)):
        firmware.offboard_setpoint(held)
        simulation.advance((tick + 1) * TICK_S)
        estimates.append(firmware.estimate)
    return state_series(estimates, TICK_S)


def _windows(states: StateSeries, starts_s: Iterable[float], window_s: float) -> Wander:
    """The mean over windows of one length; the horizontal axes are turned into the heading of each."""
    variances, powers = [], []
    for start_s in starts_s:
        time_s = start_s + np.arange(0.0, window_s, 1.0 / RATE_HZ)
        position, velocity, attitude = (
            _at(time_s, states.time_s, values)
            for values in (states.position, states.velocity, np.unwrap(states.attitude, axis=0))
        )
        to_north = Rotation.from_rotvec((0.0, 0.0, -float(np.mean(attitude[:, 2]))))
        position, velocity = to_north.apply(position), to_north.apply(velocity)
        drift = np.gradient(position, 1.0 / RATE_HZ, axis=0) - velocity
        moved = (position, velocity, attitude, drift)
        variances.append([values.var(axis=0) for values in moved])
        powers.append([_octaves(values) for values in moved])
    return Wander(np.mean(variances, axis=0), np.mean(powers, axis=0))


def _octaves(values: Vec3s) -> Float[Array, "3 octaves"]:
    """Power of each column in each octave."""
    frequency, density = periodogram(values, RATE_HZ, window="hann", axis=0)
    inside = [(frequency >= low) & (frequency < high) for low, high in OCTAVES_HZ]
    return np.column_stack([density[octave].sum(axis=0) * frequency[1] for octave in inside])


def _at(time_s: Times, known_s: Times, values: Vec3s) -> Vec3s:
    return np.column_stack([np.interp(time_s, known_s, column) for column in values.T])
