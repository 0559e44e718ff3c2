"""The flight that an inverse network learns from: sums of sinusoids along all three axes."""

from dataclasses import asdict

import numpy as np

from companion.arrays import Times, Vec3, Vec3s
from companion.errors import InputError
from companion.trajectory.limits import Limits, Peaks, peaks_of
from companion.trajectory.placement import LOWEST_M
from companion.trajectory.timing import Path, along, window_to_reach
from companion.trajectory.trajectory import Trajectory

SPEED_M_S = 2.0
"""Peak speed where none is asked for."""
LIMITS = Limits(speed_m_s=SPEED_M_S, acceleration_m_s2=7.0, jerk_m_s3=80.0)
"""Jerkier than what is tracked: where all is smooth, the vehicle's state alone tells the reference, and a
network would learn to repeat what the vehicle does instead of how to make it do something else."""

_SINUSOIDS = 10
"""How many to each axis."""
_FASTEST_HZ = 2.0
_SHARE_OF_ACCELERATION = 0.2
"""Of the limit, for any one sinusoid."""
_SAMPLE_S = 0.02


def training_sinusoids(
    duration_s: float = 400.0,
    box_m: tuple[float, float, float] = (5.0, 5.0, 3.0),
    limits: Limits | None = None,
    seed: int = 0,
) -> Trajectory:
    """Sums of sinusoids on all axes, from rest to rest, as large as box and limits allow.

    Training on 400 s of three-dimensional sinusoids is the paper's (section VII). Here the sinusoids of an
    axis have about equal speeds as far as acceleration allows, and frequencies spread over a range, at
    random within it.

    Args:
        duration_s: from the first to the last instant (s).
        box_m: sides of the box (m) along north, east and up. Its floor is `LOWEST_M` above takeoff and
            has its middle at north 0, east 0.
        limits: by default `LIMITS`; `SPEED_M_S` where no speed is asked for.
        seed: of frequencies, amplitudes and phases.

    Raises:
        InputError: a side of the box is not positive, or the time is too short to start and stop.
    """
    if not all(0.0 < side < np.inf for side in box_m):
        raise InputError(f"training box {box_m}: give three positive sides in metres")
    allowed = (limits or LIMITS).peaks(usual_speed_m_s=SPEED_M_S)
    window_s = window_to_reach(allowed.speed_m_s, allowed)
    if not duration_s > 2.0 * window_s:
        raise InputError(f"training of {duration_s} s is too short: give more than {2.0 * window_s:.1f} s")
    moving_s = duration_s - window_s
    times = np.linspace(0.0, moving_s, int(np.ceil(moving_s / _SAMPLE_S)) + 1)
    path = Path(_sinusoids(times, np.array(box_m), allowed, np.random.default_rng(seed)), end=moving_s)
    eased = along("training", path, np.ones(len(times)), window_s)
    return _as_large_as_allowed(eased.stretched(duration_s / eased.duration_s), np.array(box_m), allowed)


def _sinusoids(times: Times, box: Vec3, allowed: Peaks, rng: np.random.Generator) -> Vec3s:
    """The sums around 0 (NED), in proportion to each axis's own top speed."""
    speed = np.array([allowed.speed_m_s, allowed.speed_m_s, min(allowed.up_m_s, allowed.down_m_s)])
    # Sinusoids that share a speed v fill a side b if the slowest has about v / (8 b) Hz.
    slowest = np.minimum(speed / (8.0 * box), 0.25 * _FASTEST_HZ)
    shape = (_SINUSOIDS, 3)
    octaves = (np.arange(_SINUSOIDS)[:, None] + rng.uniform(-0.5, 0.5, shape)) / (_SINUSOIDS - 1)
    omegas = 2.0 * np.pi * slowest * (_FASTEST_HZ / slowest) ** octaves
    acceleration = np.minimum(allowed.acceleration_m_s2, [np.inf, np.inf, allowed.vertical_acceleration_m_s2])
    speeds = np.minimum(speed, _SHARE_OF_ACCELERATION * acceleration / omegas)
    amplitudes = rng.uniform(0.7, 1.3, shape) * speeds / omegas
    phases = rng.uniform(0.0, 2.0 * np.pi, shape)
    waves = amplitudes * np.sin(omegas * times[:, None, None] + phases)
    return np.asarray(waves.sum(axis=1))


def _as_large_as_allowed(trajectory: Trajectory, box: Vec3, allowed: Peaks) -> Trajectory:
    """The trajectory in the middle of the box, enlarged or reduced until box or limits allow no more.

    Every peak is in proportion to the size of the motion, so each limit allows a factor.
    """
    samples = trajectory.sample(np.arange(0.0, trajectory.duration_s, _SAMPLE_S))
    lowest, highest = samples.position.min(axis=0), samples.position.max(axis=0)
    coefficients = trajectory.coefficients.copy()
    coefficients[:, 0] -= 0.5 * (lowest + highest)
    peaks = peaks_of(trajectory)
    horizontal = allowed.speed_m_s / np.linalg.norm(samples.velocity[:, :2], axis=1).max()
    vertical = min(
        allowed.up_m_s / peaks.up_m_s,
        allowed.down_m_s / peaks.down_m_s,
        allowed.vertical_acceleration_m_s2 / peaks.vertical_acceleration_m_s2,
    )
    coefficients *= np.minimum(box / (highest - lowest), [horizontal, horizontal, vertical])
    peaks = peaks_of(Trajectory(trajectory.name, trajectory.step_s, coefficients))
    coefficients *= min(1.0, *(limit / getattr(peaks, name) for name, limit in asdict(allowed).items()))
    coefficients[:, 0, 2] -= LOWEST_M + 0.5 * box[2]
    return Trajectory(trajectory.name, trajectory.step_s, coefficients)
