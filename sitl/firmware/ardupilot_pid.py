"""ArduPilot's PID controllers and filters (`libraries/AC_PID`, `libraries/Filter`), as kernels."""

import math
from typing import NamedTuple

import numpy as np
from jaxtyping import Float

from sitl.arrays import Array
from sitl.compiled import compiled
from sitl.firmware.ardupilot_shaping import Plane, clip, limit_length

PidState = Float[Array, "4"]
"""Filtered target, filtered error, filtered derivative of the error, integral; in place."""

PlanePidState = Float[Array, "3 2"]
"""Filtered error, filtered derivative of the error, integral (m/s²) of north and east; in place."""


class PidGains(NamedTuple):
    """Gains, limit of the integral, cut-off frequencies (Hz, 0: none) of target, error and derivative."""

    p: float
    i: float
    d: float = 0.0
    feed_forward: float = 0.0
    i_max: float = math.inf
    target_hz: float = 0.0
    error_hz: float = 0.0
    derivative_hz: float = 0.0


@compiled
def blend(cutoff_hz: float, dt: float) -> float:
    """Share of the new value in a first-order low pass of `cutoff_hz` (0: no filter)."""
    return dt / (dt + 1.0 / (2.0 * math.pi * cutoff_hz)) if cutoff_hz > 0.0 else 1.0


@compiled
def reset_pid(state: PidState, target: float, measured: float) -> None:
    """Begin anew from here, without a derivative; the integral stays."""
    state[0] = target
    state[1] = target - measured
    state[2] = 0.0


@compiled
def update_pid(
    gains: PidGains, state: PidState, target: float, measured: float, limited: bool, dt: float
) -> float:
    """PID output; where the actuators are `limited` the integral may only shrink."""
    state[0] += blend(gains.target_hz, dt) * (target - state[0])
    before = state[1]
    state[1] += blend(gains.error_hz, dt) * (state[0] - measured - state[1])
    state[2] += blend(gains.derivative_hz, dt) * ((state[1] - before) / dt - state[2])
    if not limited or state[3] * state[1] < 0.0:
        state[3] = clip(state[3] + gains.i * state[1] * dt, -gains.i_max, gains.i_max)
    out: float = gains.p * state[1] + state[3] + gains.d * state[2] + gains.feed_forward * state[0]
    return out


@compiled
def update_pid_xy(
    gains: PidGains, state: PlanePidState, target: Plane, measured: Plane, limit: Plane, dt: float
) -> Plane:
    """PID output in the plane; the integral does not grow along `limit`, where the output was cut off."""
    push = 0.0
    last = math.hypot(state[2, 0], state[2, 1])
    for axis in range(2):
        before = state[0, axis]
        state[0, axis] += blend(gains.error_hz, dt) * (target[axis] - measured[axis] - state[0, axis])
        raw = (state[0, axis] - before) / dt
        state[1, axis] += blend(gains.derivative_hz, dt) * (raw - state[1, axis])
        state[2, axis] += gains.i * state[0, axis] * dt
        push += state[0, axis] * limit[axis]
    longest = min(last, gains.i_max) if push > 0.0 else gains.i_max
    state[2, 0], state[2, 1] = limit_length(state[2, 0], state[2, 1], longest)
    return (
        gains.p * state[0, 0] + state[2, 0] + gains.d * state[1, 0] + gains.feed_forward * target[0],
        gains.p * state[0, 1] + state[2, 1] + gains.d * state[1, 1] + gains.feed_forward * target[1],
    )


class LowPass(NamedTuple):
    """A second-order Butterworth low pass of several signals (`LowPassFilter2p`).

    Attributes:
        b0, a1, a2: coefficients; the numerator is b0 (1 + 2 z⁻¹ + z⁻²).
        memory: the two newest inner values of each signal.
    """

    b0: float
    a1: float
    a2: float
    memory: Float[Array, "n 2"]


def low_pass(signals: int, cutoff_hz: float, dt: float) -> LowPass:
    """At rest at zero, called every `dt` (s)."""
    omega = math.tan(math.pi * cutoff_hz * dt)
    scale = 1.0 + math.sqrt(2.0) * omega + omega**2
    return LowPass(
        b0=omega**2 / scale,
        a1=2.0 * (omega**2 - 1.0) / scale,
        a2=(1.0 - math.sqrt(2.0) * omega + omega**2) / scale,
        memory=np.zeros((signals, 2)),
    )


@compiled
def settle(filtered: LowPass, signal: int, value: float) -> None:
    """Let the filter have seen nothing but `value`."""
    for i in range(2):
        filtered.memory[signal, i] = value / (1.0 + filtered.a1 + filtered.a2)


@compiled
def smooth(filtered: LowPass, signal: int, value: float) -> float:
    """The filtered signal after one more `value`."""
    memory = filtered.memory
    inner = value - filtered.a1 * memory[signal, 0] - filtered.a2 * memory[signal, 1]
    out: float = filtered.b0 * (inner + 2.0 * memory[signal, 0] + memory[signal, 1])
    memory[signal, 1] = memory[signal, 0]
    memory[signal, 0] = inner
    return out
