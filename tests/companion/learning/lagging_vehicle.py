"""A vehicle for the tests: a linear system that follows its reference like a damped spring, with a lag."""

import numpy as np
from numpy.typing import ArrayLike

from companion.arrays import Array, Times, Vec3, Vec3s
from companion.recording.series import Provenance, Recording, ReferenceSeries, StateSeries

STIFFNESS, DAMPING, LAG_S = 4.0, 3.2, 0.15
STEP_S = 0.02


class LaggingVehicle:
    """Position, velocity and acceleration (3,), moved on by `step`; it tilts by what it accelerates."""

    def __init__(self, position: ArrayLike, velocity: ArrayLike) -> None:
        self.position: Vec3 = np.array(position, dtype=float)
        self.velocity: Vec3 = np.array(velocity, dtype=float)
        self.acceleration: Vec3 = np.zeros(3)
        self._jerk: Vec3 = np.zeros(3)

    def step(self, reference: Vec3, reference_velocity: Vec3) -> None:
        wanted = STIFFNESS * (reference - self.position) + DAMPING * (reference_velocity - self.velocity)
        self._jerk = (wanted - self.acceleration) / LAG_S
        self.acceleration = self.acceleration + STEP_S * self._jerk
        self.velocity = self.velocity + STEP_S * self.acceleration
        self.position = self.position + STEP_S * self.velocity

    def attitude(self, yaw: float) -> Vec3:
        return np.append(_tilt(self.acceleration, yaw), yaw)

    def rates(self, yaw: float) -> Vec3:
        return np.append(_tilt(self._jerk, yaw), 0.0)


def _tilt(acceleration: Vec3, yaw: float) -> Array:
    """Roll and pitch that give the horizontal acceleration, or their rates that give its derivative."""
    forward = np.cos(yaw) * acceleration[0] + np.sin(yaw) * acceleration[1]
    right = np.cos(yaw) * acceleration[1] - np.sin(yaw) * acceleration[0]
    return np.array([right, -forward]) / 9.81


def sinusoids(time_s: Times, seed: int) -> tuple[Vec3s, Vec3s]:
    """Position and velocity of a smooth motion in three axes (n, 3)."""
    rng = np.random.default_rng(seed)
    pulsation = rng.uniform(0.3, 2.5, size=(8, 3))
    phase = rng.uniform(0.0, 2.0 * np.pi, size=(8, 3))
    angle = pulsation * time_s[:, None, None] + phase
    return 0.3 * np.sin(angle).sum(axis=1), 0.3 * (pulsation * np.cos(angle)).sum(axis=1)


def flight(seconds: float, seed: int, yaw: float = 0.0) -> Recording:
    """The vehicle's flight along `sinusoids`, as recorded."""
    time_s = np.arange(0.0, seconds, STEP_S)
    reference, reference_velocity = sinusoids(time_s, seed)
    vehicle = LaggingVehicle(reference[0], reference_velocity[0])
    flown = np.empty((len(time_s), 12))
    for k in range(len(time_s)):
        flown[k] = np.hstack((vehicle.position, vehicle.velocity, vehicle.attitude(yaw), vehicle.rates(yaw)))
        vehicle.step(reference[k], reference_velocity[k])
    states = StateSeries(time_s, flown[:, 0:3], flown[:, 3:6], flown[:, 6:9], flown[:, 9:12])
    references = ReferenceSeries(
        time_s, reference, reference_velocity, np.full_like(reference, np.nan), np.full_like(time_s, yaw)
    )
    return Recording(Provenance(vehicle="spring"), states, references)
