"""PX4 between two steps of its position controller: attitude, rates and allocation, compiled."""

from typing import NamedTuple

from sitl.compiled import compiled
from sitl.estimator import Estimator
from sitl.firmware.px4_allocation import Allocation, allocate
from sitl.firmware.px4_attitude import (
    AttitudeGains,
    RateGains,
    RateState,
    control_attitude,
    control_rates,
)
from sitl.firmware.px4_position import AttitudeSetpoint
from sitl.plant import STEP_S, STEPS_PER_TICK, Plant, TickNoise, begin_tick, end_tick, step

_ATTITUDE_PERIOD = 4
"""Steps between two of the attitude controller: 250 Hz."""


class InnerLoops(NamedTuple):
    """Attitude and rate control with the allocation to the rotors."""

    attitude: AttitudeGains
    rates: RateGains
    state: RateState
    allocation: Allocation


@compiled
def fly_tick(
    plant: Plant,
    estimate: Estimator,
    loops: InnerLoops,
    setpoint: AttitudeSetpoint,
    armed: bool,
    on_ground: bool,
    first_step: int,
    noise: TickNoise,
) -> None:
    """Advance plant and estimate by one tick under one attitude setpoint, in place.

    `on_ground` (as the firmware has it) holds the rate integrals; `first_step` counts steps since boot.
    """
    top_speed = begin_tick(plant, estimate, noise)
    for i in range(STEPS_PER_TICK):
        number = first_step + i
        if number % _ATTITUDE_PERIOD == 0:
            control_attitude(loops.attitude, setpoint, estimate.attitude, loops.state)
        torque = control_rates(loops.rates, loops.state, estimate.rates, on_ground, STEP_S)
        thrusts = allocate(loops.allocation, torque, setpoint.thrust_and_yaw_rate[0], loops.state)
        step(plant, estimate, thrusts, armed, top_speed, number, noise.estimate[i])
    end_tick(plant)
