"""Recordings of simulated vehicles, made without a companion or a link."""

from collections.abc import Callable
from typing import TypeAlias

import numpy as np

from companion.arrays import Vec3
from companion.experiments.twin import state_series
from companion.recording import Provenance, Recording, ReferenceSeries, Segment, Window
from sitl.conditions import Conditions
from sitl.estimator_errors import EstimatorErrors
from sitl.firmware.interface import Setpoint
from sitl.plant import TICK_S
from sitl.simulation import Simulation
from sitl.vehicle import Vehicle

Path: TypeAlias = Callable[[float], tuple[Vec3, Vec3]]
"""Position and velocity (NED, m, m/s) wanted at a time (s)."""

HOVER = np.array((0.0, 0.0, -100.0, *np.zeros(3), 1.0, *np.zeros(6)))
BOOT_S = 40.0
"""When the recording's clock begins."""


def weave(time_s: float) -> tuple[Vec3, Vec3]:
    """A sum of sinusoids on all axes, which begins at rest."""
    frequency = np.array(((1.1, 0.5), (0.9, 1.7), (0.7, 1.3)))
    amplitude = np.array(((1.0, 1.5), (1.2, 0.5), (0.8, 0.4)))
    phase = frequency * time_s
    position = (amplitude * (1.0 - np.cos(phase))).sum(axis=1)
    velocity = (amplitude * frequency * np.sin(phase)).sum(axis=1)
    return HOVER[:3] + position, velocity


def fly(
    vehicle: Vehicle,
    duration_s: float,
    *,
    path: Path = weave,
    errors: EstimatorErrors | None = None,
    segments: tuple[str, ...] = ("weave",),
) -> Recording:
    """Setpoints of position and velocity every 20 ms, states every 10 ms, in segments of equal length."""
    conditions = Conditions(name="test", estimator=errors or EstimatorErrors())
    simulation = Simulation(vehicle, conditions, seed=1, motion=HOVER)
    estimates, sent = [], []
    for tick in range(round(duration_s / TICK_S)):
        if tick % 2 == 0:
            position, velocity = path(tick * TICK_S)
            sent.append((BOOT_S + tick * TICK_S, *position, *velocity))
            simulation.firmware.offboard_setpoint(Setpoint(position, velocity, yaw=0.0))
        estimates.append(simulation.firmware.estimate)
        simulation.advance((tick + 1) * TICK_S)
    rows = np.array(sent)
    ends = np.linspace(BOOT_S + 0.1, BOOT_S + duration_s - 0.1, len(segments) + 1)
    return Recording(
        Provenance(vehicle=vehicle.name),
        state_series(estimates, BOOT_S),
        ReferenceSeries(
            rows[:, 0], rows[:, 1:4], rows[:, 4:7], np.full((len(rows), 3), np.nan), np.zeros(len(rows))
        ),
        segments=tuple(
            Segment(name, Window(float(start_s), float(end_s)))
            for name, start_s, end_s in zip(segments, ends[:-1], ends[1:], strict=True)
        ),
    )
