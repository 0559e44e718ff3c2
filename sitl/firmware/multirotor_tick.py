"""One tick of flight, compiled: inner control loops, rotors, rigid body and estimator at 1 kHz."""

import math
from typing import NamedTuple

from jaxtyping import Float

from sitl.arrays import Array
from sitl.battery import Pack, drain
from sitl.compiled import compiled
from sitl.estimator import STEPS_PER_S, Estimator, compose, draw
from sitl.firmware.px4_allocation import Allocation, allocate
from sitl.firmware.px4_attitude import (
    AttitudeGains,
    RateGains,
    RateState,
    control_attitude,
    control_rates,
)
from sitl.firmware.px4_position import AttitudeSetpoint
from sitl.rigid_body import Airframe, Body, advance
from sitl.wind import Wind, blow

STEPS_PER_TICK = 10
_STEP_S = 1.0 / STEPS_PER_S
_ATTITUDE_PERIOD = 4


class Plant(NamedTuple):
    """The physical world: vehicle and air."""

    airframe: Airframe
    body: Body
    pack: Pack
    air: Wind


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
    wind_noise: Float[Array, "5"],
    estimate_noise: Float[Array, "10 12"],
) -> None:
    """Advance plant and estimate by ten steps of 1 ms under one attitude setpoint, in place.

    `on_ground` (as the firmware has it) holds the rate integrals; `first_step` counts steps since boot.
    """
    frame, body = plant.airframe, plant.body
    tick_s = STEPS_PER_TICK * _STEP_S
    blow(plant.air, body.motion[0:3], body.motion[3:6], wind_noise, tick_s)
    top_speed = frame.max_speed * plant.pack.state[1] / plant.pack.full_voltage
    for i in range(STEPS_PER_TICK):
        step = first_step + i
        if step % _ATTITUDE_PERIOD == 0:
            control_attitude(loops.attitude, setpoint, estimate.attitude, loops.state)
        torque = control_rates(loops.rates, loops.state, estimate.rates, on_ground, _STEP_S)
        speeds = allocate(loops.allocation, torque, setpoint.thrust_and_yaw_rate[0], loops.state)
        for rotor in range(speeds.size):
            if armed:
                speeds[rotor] = max(frame.min_speed, top_speed * math.sqrt(speeds[rotor]))
            else:
                speeds[rotor] = 0.0
        advance(frame, body, speeds, plant.air.now, _STEP_S)
        draw(estimate, step, estimate_noise[i])
        compose(estimate, body.motion)
    drain(plant.pack, frame, body.rotor_speed, tick_s)
