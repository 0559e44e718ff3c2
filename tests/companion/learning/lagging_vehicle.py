"""A vehicle for the tests: each axis follows its reference like a damped spring, a known linear system."""

import numpy as np

from companion.arrays import Times, Vec3s
from companion.recording.series import Provenance, Recording, ReferenceSeries, StateSeries

STIFFNESS, DAMPING = 4.0, 3.2
STEP_S = 0.02


def acceleration(position: Vec3s, velocity: Vec3s, reference: Vec3s, reference_velocity: Vec3s) -> Vec3s:
    return STIFFNESS * (reference - position) + DAMPING * (reference_velocity - velocity)


def sinusoids(time_s: Times, seed: int) -> tuple[Vec3s, Vec3s]:
    """Position and velocity of a smooth motion in three axes (n, 3)."""
    rng = np.random.default_rng(seed)
    pulsation = rng.uniform(0.3, 2.0, size=(4, 3))
    phase = rng.uniform(0.0, 2.0 * np.pi, size=(4, 3))
    angle = pulsation * time_s[:, None, None] + phase
    return 0.4 * np.sin(angle).sum(axis=1), 0.4 * (pulsation * np.cos(angle)).sum(axis=1)


def flight(seconds: float, seed: int, yaw: float = 0.0) -> Recording:
    """The vehicle's flight along `sinusoids`, as recorded; tilt in proportion to the acceleration."""
    time_s = np.arange(0.0, seconds, STEP_S)
    reference, reference_velocity = sinusoids(time_s, seed)
    position, velocity = np.zeros_like(reference), np.zeros_like(reference)
    pushed = np.zeros_like(reference)
    position[0], velocity[0] = reference[0], reference_velocity[0]
    for k in range(len(time_s)):
        pushed[k] = acceleration(position[k], velocity[k], reference[k], reference_velocity[k])
        if k + 1 < len(time_s):
            velocity[k + 1] = velocity[k] + STEP_S * pushed[k]
            position[k + 1] = position[k] + STEP_S * velocity[k + 1]
    tilt = pushed / 9.81
    forward = np.cos(yaw) * tilt[:, 0] + np.sin(yaw) * tilt[:, 1]
    right = np.cos(yaw) * tilt[:, 1] - np.sin(yaw) * tilt[:, 0]
    attitude = np.column_stack((right, -forward, np.full(len(time_s), yaw)))
    states = StateSeries(time_s, position, velocity, attitude, np.gradient(attitude, STEP_S, axis=0))
    references = ReferenceSeries(time_s, reference, reference_velocity, np.full_like(reference, np.nan))
    return Recording(Provenance(vehicle="spring"), states, references)
