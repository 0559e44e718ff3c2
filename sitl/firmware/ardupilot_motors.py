"""ArduPilot's mixer for a multirotor: roll, pitch, yaw and throttle to rotor thrusts (`AP_MotorsMatrix`).

Where it asks more than the rotors have, yaw is lowered first (but for a headroom), then the throttle moves,
then roll and pitch are scaled. The plant takes thrusts, so that ArduPilot's linearisation of motor and
propeller (MOT_THST_EXPO) and its compensation of the battery's voltage are taken as perfect.
"""

from typing import NamedTuple

import numpy as np
from jaxtyping import Bool, Float

from sitl.arrays import Array, Vec3
from sitl.compiled import compiled
from sitl.vehicle import Vehicle

MotorLimits = Bool[np.ndarray[tuple[int, ...], np.dtype[np.bool_]], "4"]
"""Whether the last mix fell short: of roll and pitch, of yaw, at the least throttle, at the most."""


class Mixer(NamedTuple):
    """Rotor thrusts (fraction of the maximum) for a unit of roll, pitch and yaw, and the headroom of yaw."""

    factors: Float[Array, "n 3"]
    yaw_headroom: float


def mixer(vehicle: Vehicle, yaw_headroom: float) -> Mixer:
    """The mix of a geometry: a unit of each changes the most affected rotors by half their range."""
    effect = vehicle.rotor_effectiveness[:3]
    return Mixer(
        np.ascontiguousarray((0.5 * effect / np.abs(effect).max(axis=1, keepdims=True)).T), yaw_headroom
    )


def authority(vehicle: Vehicle) -> Vec3:
    """Angular acceleration of a unit of roll, pitch and yaw output (rad/s²)."""
    torque: Vec3 = np.sum(vehicle.rotor_effectiveness[:3] * mixer(vehicle, 0.0).factors.T, axis=1)
    return torque / vehicle.inertia_kg_m2


@compiled
def mix(
    frame: Mixer, output: Vec3, throttle: float, highest_mean: float, limits: MotorLimits
) -> Float[Array, " n"]:
    """Rotor thrusts (0 to 1).

    Args:
        frame: the vehicle's mix.
        output: of the rate controller.
        throttle: wanted mean of the thrusts.
        highest_mean: to which it may rise so that roll and pitch find room.
        limits: on return, what fell short.
    """
    factors = frame.factors
    limits[0] = limits[1] = False
    limits[2] = throttle <= 0.0
    limits[3] = throttle >= 1.0
    throttle = min(max(throttle, 0.0), 1.0)
    highest_mean = min(max(highest_mean, throttle), 1.0)
    room = min(0.5, highest_mean)
    thrusts: Float[Array, " n"] = factors[:, 0] * output[0] + factors[:, 1] * output[1]
    allowed = 1.0
    for i in range(thrusts.size):
        share = factors[i, 2]
        if share != 0.0:
            base = room + thrusts[i]
            left = 1.0 - base if output[2] * share > 0.0 else base
            allowed = min(allowed, max(left, 0.0) / abs(share))
    allowed = max(allowed, frame.yaw_headroom)
    yaw = min(max(output[2], -allowed), allowed)
    limits[1] = yaw != output[2]
    thrusts += factors[:, 2] * yaw
    low, high = thrusts.min(), thrusts.max()
    scale = 1.0
    if high - low > 1.0:
        scale = 1.0 / (high - low)
    if highest_mean + low < 0.0:
        scale = min(scale, -highest_mean / low)
    low *= scale
    high *= scale
    if scale < 1.0:
        limits[0] = limits[1] = True
        limits[3] = limits[3] or throttle > -low
        mean = -low
    else:
        mean = min(max(throttle, -low), 1.0 - high)
        limits[3] = limits[3] or mean < throttle
    for i in range(thrusts.size):
        thrusts[i] = min(max(mean + scale * thrusts[i], 0.0), 1.0)
    return thrusts
