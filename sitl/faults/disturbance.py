"""What faults do to rotors, air, battery and estimate: sums over those that are there, written each tick."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float

from sitl.arrays import Array, Vec3
from sitl.estimator import CONTENT, Estimator, announce
from sitl.faults import kinds
from sitl.faults.schedule import Active, Change
from sitl.plant import Plant

_VELOCITY_GATE_M_S, _HEADING_GATE_RAD = 5.0 * 0.3, 2.6 * 0.3
"""EKF2_GPS_V_GATE and EKF2_HDG_GATE times EKF2_GPS_V_NOISE and EKF2_HEAD_NOISE."""


@dataclass(frozen=True, eq=False)
class Disturbance:
    """How far the world and the estimate are off.

    Attributes:
        effectiveness: of each rotor (0 to 1).
        gust: NED (m/s).
        position, velocity: error of the estimate, NED (m, m/s).
        yaw: error of the estimated heading (rad).
    """

    effectiveness: Float[Array, " n"]
    gust: Vec3
    position: Vec3
    velocity: Vec3
    yaw: float


def disturbance(active: Sequence[Active], time_s: float, rotors: int) -> Disturbance:
    """The sum of what is there at `time_s` (s since boot). A rotor that there is not cannot fail."""
    effectiveness = np.ones(rotors)
    gust, position, velocity, yaw = np.zeros(3), np.zeros(3), np.zeros(3), 0.0
    for each in active:
        elapsed_s = time_s - each.since_s
        match each.fault:
            case kinds.MotorWeak(motor=motor, effectiveness=share):
                effectiveness[motor - 1 : motor] *= share
            case kinds.MotorDead(motor=motor):
                effectiveness[motor - 1 : motor] = 0.0
            case kinds.Gust() as fault:
                full = np.array((fault.north_m_s, fault.east_m_s, fault.down_m_s))
                gust += gust_share(fault, elapsed_s) * full
            case kinds.EstimatorJump(north_m=north, east_m=east, down_m=down):
                position += (north, east, down)
            case kinds.EstimatorDrift(north_m_s=north, east_m_s=east, down_m_s=down):
                position += elapsed_s * np.array((north, east, down))
            case kinds.VelocityError(north_m_s=north, east_m_s=east, down_m_s=down):
                velocity += (north, east, down)
            case kinds.GpsLost(north_m_s2=north, east_m_s2=east):
                bias = np.array((north, east, 0.0))
                velocity += elapsed_s * bias
                position += 0.5 * elapsed_s**2 * bias
            case kinds.CompassError(error_deg=error):
                yaw += math.radians(error)
    return Disturbance(effectiveness, gust, position, velocity, yaw)


def gust_share(gust: kinds.Gust, elapsed_s: float) -> float:
    """How much of a gust there is `elapsed_s` (s) after it began (0 to 1)."""
    left_s = math.inf if gust.lasts_s is None else gust.lasts_s - elapsed_s
    risen = min(max(min(elapsed_s, left_s) / gust.rise_s, 0.0), 1.0)
    return 0.5 * (1.0 - math.cos(math.pi * risen))


def disturb(plant: Plant, estimate: Estimator, now: Disturbance) -> None:
    """Write a disturbance into plant and estimate."""
    plant.effectiveness[:] = now.effectiveness
    plant.air.gust[:] = now.gust
    estimate.offset[0], estimate.offset[1] = now.position, now.velocity
    estimate.turn[0] = now.yaw
    estimate.test_ratios[0] = CONTENT + float(now.velocity @ now.velocity) / _VELOCITY_GATE_M_S**2
    estimate.test_ratios[1] = CONTENT + (now.yaw / _HEADING_GATE_RAD) ** 2


def announce_jumps(estimate: Estimator, change: Change, before: Float[Array, "2 3"]) -> None:
    """Count as a reset what the estimate's offset became at the beginning or end of what an EKF notices."""
    if any(_is_announced(each) for each in (*change.begun, *change.ended)):
        announce(estimate, estimate.offset - before)


def _is_announced(active: Active) -> bool:
    match active.fault:
        case kinds.EstimatorJump(announced=announced):
            return announced
        case kinds.GpsLost():
            return True
    return False


def discharge(plant: Plant, change: Change) -> None:
    """Let batteries collapse that begin to."""
    for each in change.begun:
        if isinstance(each.fault, kinds.BatteryCollapse):
            plant.pack.state[0] = min(plant.pack.state[0], each.fault.remaining)
