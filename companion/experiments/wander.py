"""How an autopilot's estimate wanders, recorded and simulated: powers in octaves of windows of one length."""

from collections.abc import Iterable
from dataclasses import dataclass
from typing import NamedTuple, TypeAlias

import numpy as np
from jaxtyping import Float
from scipy.signal import periodogram
from scipy.spatial.transform import Rotation

from companion.arrays import Array, Times, Vec3, Vec3s
from companion.errors import InputError
from companion.experiments.twin import state_series
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

_IN_HOVER = np.array((0.0, 0.0, -100.0, *np.zeros(3), 1.0, *np.zeros(6)))
_SETTLING_S = 20.0
COMPARED_WINDOWS = 48
"""Of a twin beside its recording: with 12, chance alone moved a standard deviation by a third."""

Moments: TypeAlias = Float[Array, "4 3 moments"]


@dataclass(frozen=True, eq=False)
class Wander:
    """How an estimate moves about: mean over windows of one length.

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
    def moments(self) -> Moments:
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
    return wander_of(recording.states, [window.start_s], window.end_s - window.start_s)


def simulated_wander(
    vehicle: Vehicle,
    errors: EstimatorErrors,
    window_s: float,
    *,
    windows: int,
    seed: int = 0,
) -> Wander:
    """In hover under these errors, the mean over windows of `window_s` (s), one after another."""
    states = hover_of(vehicle, errors, _SETTLING_S + windows * window_s, seed)
    return wander_of(states, _SETTLING_S + window_s * np.arange(windows), window_s)


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


def wander_of(states: StateSeries, starts_s: Iterable[float], window_s: float) -> Wander:
    """Mean over the windows of `window_s` (s) that begin there; north is where each is headed for."""
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
