"""Flights of a vehicle whose closed loop is known: a damped spring on its reference, with a lag."""

from dataclasses import replace

import numpy as np
from scipy.linalg import expm

from companion.arrays import Array, Times, Vec3s
from companion.recording import Provenance, Recording, ReferenceSeries, StateSeries
from companion.similarity.identification import AxisModel
from companion.similarity.linear_system import LinearSystem

STEP_S = 0.02


def sinusoids(time_s: Times, seed: int) -> tuple[Vec3s, Vec3s, Vec3s]:
    """A reference's position, velocity and acceleration."""
    rng = np.random.default_rng(seed)
    pulsation = rng.uniform(0.3, 5.0, size=(10, 3))
    angle = pulsation * time_s[:, None, None] + rng.uniform(0.0, 2.0 * np.pi, size=(10, 3))
    amplitude = 0.5 / pulsation
    return (
        (amplitude * np.sin(angle)).sum(axis=1),
        (amplitude * pulsation * np.cos(angle)).sum(axis=1),
        -(amplitude * pulsation**2 * np.sin(angle)).sum(axis=1),
    )


def spring_flight(
    *,
    stiffness: float = 4.0,
    damping: float = 3.2,
    lag_s: float = 0.15,
    delay_s: float = 0.06,
    noise: float = 0.0,
    seconds: float = 40.0,
    seed: int = 0,
) -> Recording:
    """The vehicle's flight along `sinusoids`; each axis is alike.

    lag_s a'(t) + a(t) = w(t), w the pull of position and velocity errors and the reference's acceleration, of
    `delay_s` ago.
    """
    time_s = np.arange(0.0, seconds, STEP_S)
    position, velocity, acceleration = sinusoids(time_s - delay_s, seed)
    pull = stiffness * position + damping * velocity + acceleration
    A = np.array([[0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [-stiffness / lag_s, -damping / lag_s, -1.0 / lag_s]])
    both = np.zeros((4, 4))
    both[:3, :3], both[2, 3] = A, 1.0 / lag_s
    step: Array = expm(both * STEP_S)
    states = np.zeros((len(time_s), 3, 3))
    for k in range(len(time_s) - 1):
        states[k + 1] = step[:3, :3] @ states[k] + np.outer(step[:3, 3], pull[k])
    states += noise * np.random.default_rng(seed).standard_normal(states.shape)
    sent = sinusoids(time_s, seed)
    tilt = np.arctan(states[:, 2] / 9.80665)
    attitude = np.column_stack((tilt[:, 1], -tilt[:, 0], np.zeros(len(time_s))))
    flown = StateSeries(time_s, states[:, 0], states[:, 1], attitude, np.zeros_like(attitude))
    return Recording(
        Provenance(vehicle="spring"), flown, ReferenceSeries(time_s, *sent, np.zeros(len(time_s)))
    )


def answering_the_wrong_way(model: AxisModel) -> AxisModel:
    """A model of the same poles whose output first goes the wrong way: a zero at 1.5."""
    poles = np.poly(model.system.A)
    companion_matrix = np.diag(np.ones(2), 1)
    companion_matrix[2] = -poles[:0:-1]
    gain = 0.01
    system = LinearSystem(companion_matrix, np.array([0.0, 0.0, 1.0]), gain * np.array([0.15, -1.6, 1.0]))
    return replace(model, system=system)
