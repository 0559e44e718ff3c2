"""The physical world of one vehicle, moved on at 1 kHz: rotors, rigid body, battery and air."""

import math
from typing import NamedTuple

import numpy as np
from jaxtyping import Float

from sitl.arrays import Array
from sitl.battery import Pack, drain, full_pack
from sitl.compiled import compiled
from sitl.estimator import STEPS_PER_S, Estimator, compose, draw, wander
from sitl.rigid_body import Airframe, Body, advance, airframe, body_in_flight, body_on_ground
from sitl.vehicle import Vehicle
from sitl.wind import Wind, blow

STEPS_PER_TICK = 10
STEP_S = 1.0 / STEPS_PER_S
TICK_S = STEPS_PER_TICK * STEP_S


class Plant(NamedTuple):
    """Vehicle and air.

    Attributes:
        thrusts: commanded thrusts of the rotors (0 to 1) of the newest steps, a ring by step.
        effectiveness: share of thrust and drag torque that each rotor still has (0 to 1).
    """

    airframe: Airframe
    body: Body
    thrusts: Float[Array, "m n"]
    effectiveness: Float[Array, " n"]
    pack: Pack
    air: Wind


class TickNoise(NamedTuple):
    """Standard normal numbers for one tick."""

    wind: Float[Array, "5"]
    wander: Float[Array, "4 3"]
    estimate: Float[Array, "10 12"]


def plant(vehicle: Vehicle, air: Wind, motion: Float[Array, "13"] | None = None) -> Plant:
    """A vehicle in flight with this motion (`Body.motion`), else at rest on the ground; battery full."""
    rotors = len(vehicle.rotors.layout)
    delay = round(vehicle.rotors.delay_s * STEPS_PER_S)
    body = body_on_ground(rotors) if motion is None else body_in_flight(vehicle, motion)
    thrust = 0.0 if motion is None else vehicle.hover_thrust
    thrusts = np.full((delay + 1, rotors), thrust)
    return Plant(airframe(vehicle), body, thrusts, np.ones(rotors), full_pack(vehicle), air)


@compiled
def begin_tick(plant: Plant, estimate: Estimator, noise: TickNoise) -> float:
    """Move air and wander on by a tick; the rotor speed that the battery gives for full thrust (rad/s)."""
    motion = plant.body.motion
    blow(plant.air, motion[0:3], motion[3:6], noise.wind, TICK_S)
    wander(estimate, noise.wander, TICK_S)
    return float(plant.airframe.max_speed * plant.pack.state[1] / plant.pack.full_voltage)


@compiled
def step(
    plant: Plant,
    estimate: Estimator,
    thrusts: Float[Array, " n"],
    armed: bool,
    top_speed: float,
    number: int,
    noise: Float[Array, "12"],
) -> None:
    """Move vehicle and estimate on by 1 ms, to the step after `number`, under commanded thrusts (0 to 1)."""
    frame, ring = plant.airframe, plant.thrusts
    size = ring.shape[0]
    speeds = np.empty(thrusts.size)
    for rotor in range(thrusts.size):
        ring[number % size, rotor] = thrusts[rotor]
        acting = ring[(number + 1) % size, rotor]
        speed = max(frame.min_speed, top_speed * math.sqrt(acting)) if armed else 0.0
        speeds[rotor] = math.sqrt(plant.effectiveness[rotor]) * speed
    advance(frame, plant.body, speeds, plant.air.now, STEP_S)
    draw(estimate, number, noise)
    compose(estimate, number, plant.body.motion)


@compiled
def end_tick(plant: Plant) -> None:
    """Draw a tick's charge from the battery."""
    drain(plant.pack, plant.airframe, plant.body.rotor_speed, TICK_S)
