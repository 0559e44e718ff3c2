"""PX4's control allocation for a multirotor: normalised torque and thrust to rotor thrusts.

The mix is the normalised pseudo-inverse of the geometry. Where it asks more than the rotors have, thrust
is lowered first, then roll and pitch; yaw gets what is left (PX4's sequential desaturation without airmode).
"""

from typing import NamedTuple

import numpy as np
from jaxtyping import Float

from sitl.arrays import Array, Vec3
from sitl.compiled import compiled
from sitl.firmware.px4_attitude import RateState
from sitl.vehicle import Vehicle

_YAW_MARGIN = 0.15
"""Yaw may push the strongest rotor this far beyond its maximum; thrust is lowered to make room."""

_SHORT_TORQUE = 1e-3


class Allocation(NamedTuple):
    """Rotor thrusts (fraction of the maximum) for a unit of each command, and back.

    Attributes:
        mix: columns roll, pitch, yaw, thrust.
        torque: N m of a unit command about each axis.
        effect: normalised torque of each rotor's full thrust.
    """

    mix: Float[Array, "n 4"]
    torque: Vec3
    effect: Float[Array, "3 n"]


def allocation(vehicle: Vehicle) -> Allocation:
    """The allocation that fits a vehicle's geometry, scaled as PX4 scales it.

    A unit of roll or pitch changes the rotors' thrusts by 1/√2 in the root mean square of the axis that
    needs more, a unit of yaw the most affected rotor by 1, a unit of thrust all by 1.
    """
    effectiveness = vehicle.rotor_effectiveness
    mix = np.linalg.pinv(effectiveness)
    used = np.count_nonzero(np.abs(mix[:, :2]) > 1e-9 * np.abs(mix[:, :2]).max(), axis=0)
    roll_pitch = np.sqrt(np.sum(mix[:, :2] ** 2, axis=0) / (used / 2.0)).max()
    scale = np.array((roll_pitch, roll_pitch, np.abs(mix[:, 2]).max(), np.abs(mix[:, 3]).mean()))
    return Allocation(
        mix=np.ascontiguousarray(mix / scale),
        torque=1.0 / scale[:3],
        effect=np.ascontiguousarray(effectiveness[:3] * scale[:3, None]),
    )


@compiled
def excess(thrusts: Float[Array, " n"], direction: Float[Array, " n"], upper: float) -> float:
    """How far along `direction` the thrusts must move to come into 0 to `upper`; two-sided: the balance."""
    least, most = 0.0, 0.0
    for i in range(thrusts.size):
        if abs(direction[i]) < 1e-6:
            continue
        if thrusts[i] < 0.0:
            move = -thrusts[i] / direction[i]
        elif thrusts[i] > upper:
            move = (upper - thrusts[i]) / direction[i]
        else:
            continue
        least = min(least, move)
        most = max(most, move)
    return least + most


@compiled
def shift(thrusts: Float[Array, " n"], direction: Float[Array, " n"], by: float) -> None:
    """Add `by` times `direction` to the thrusts, in place."""
    for i in range(thrusts.size):
        thrusts[i] += by * direction[i]


@compiled
def desaturate(thrusts: Float[Array, " n"], direction: Float[Array, " n"], upper: float, lower: bool) -> None:
    """Move the thrusts along `direction` towards 0 to `upper` in place; `lower` allows only less of it."""
    move = excess(thrusts, direction, upper)
    if move == 0.0 or (lower and move > 0.0):
        return
    shift(thrusts, direction, move)
    # One side may have been traded for the other: half a step back shares the rest between them.
    shift(thrusts, direction, 0.5 * excess(thrusts, direction, upper))


@compiled
def allocate(matrix: Allocation, torque: Vec3, thrust: float, state: RateState) -> Float[Array, " n"]:
    """Rotor thrusts (0 to 1) for a normalised torque and a collective thrust (0 to 1).

    Notes in `state` on which axes the rotors give less than was asked.
    """
    mix = matrix.mix
    thrusts = thrust * mix[:, 3]
    shift(thrusts, mix[:, 0], torque[0])
    shift(thrusts, mix[:, 1], torque[1])
    desaturate(thrusts, mix[:, 3], 1.0, True)
    desaturate(thrusts, mix[:, 0], 1.0, False)
    desaturate(thrusts, mix[:, 1], 1.0, False)
    shift(thrusts, mix[:, 2], torque[2])
    desaturate(thrusts, mix[:, 2], 1.0 + _YAW_MARGIN, False)
    desaturate(thrusts, mix[:, 3], 1.0, True)
    for i in range(thrusts.size):
        thrusts[i] = min(max(thrusts[i], 0.0), 1.0)
    for axis in range(3):
        given = 0.0
        for i in range(thrusts.size):
            given += matrix.effect[axis, i] * thrusts[i]
        state.short_up[axis] = torque[axis] - given > _SHORT_TORQUE
        state.short_down[axis] = torque[axis] - given < -_SHORT_TORQUE
    return thrusts
