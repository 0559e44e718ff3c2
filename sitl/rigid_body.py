"""Rigid-body dynamics of a multirotor: NED world, FRD body, flat rough ground at z = 0.

Per rotor i: thrust k ω² against body z, torque ±k_m ω² about it, in-plane drag c ω v_air at the hub.
"""

import math
from typing import NamedTuple

import numpy as np
from jaxtyping import Float

from sitl.arrays import Array, Vec3
from sitl.compiled import compiled
from sitl.quaternion import normalise, to_body, to_world
from sitl.vehicle import GRAVITY_M_S2, Vehicle

_LEVELLING_TIME_S = 0.05
"""Time in which a vehicle that touched down tilted comes to rest on its legs."""


class Airframe(NamedTuple):
    """Physical constants of a vehicle, SI; a row or an element of the arrays for each rotor."""

    mass: float
    inertia: Vec3
    position: Float[Array, "n 3"]
    spin: Float[Array, " n"]
    """+1 where the reaction torque turns the body to the right: rotors that turn counter-clockwise."""
    thrust_coefficient: float
    moment_coefficient: float
    rotor_drag: float
    rotor_inertia: float
    time_constant: float
    min_speed: float
    max_speed: float
    linear_drag: Vec3
    quadratic_drag: Vec3


class Body(NamedTuple):
    """State that `advance` moves on, in place.

    Attributes:
        motion: position (3), velocity (3), attitude (4), body rates (3); NED, SI.
        rotor_speed: rad/s.
    """

    motion: Float[Array, "13"]
    rotor_speed: Float[Array, " n"]


def airframe(vehicle: Vehicle) -> Airframe:
    """The constants of a vehicle as the kernels take them."""
    rotors = vehicle.rotors
    return Airframe(
        mass=vehicle.mass_kg,
        inertia=np.array(vehicle.inertia_kg_m2),
        position=np.array([(rotor.x_m, rotor.y_m, rotor.z_m) for rotor in rotors.layout]),
        spin=np.array([1.0 if rotor.direction == "ccw" else -1.0 for rotor in rotors.layout]),
        thrust_coefficient=rotors.thrust_coefficient_n_s2,
        moment_coefficient=rotors.moment_coefficient_nm_s2,
        rotor_drag=vehicle.rotor_drag_n_s2_per_m,
        rotor_inertia=rotors.inertia_kg_m2,
        time_constant=rotors.time_constant_s,
        min_speed=rotors.min_speed_rad_s,
        max_speed=vehicle.max_speed_rad_s,
        linear_drag=np.array(vehicle.body_drag.linear_n_s_per_m),
        quadratic_drag=np.array(vehicle.body_drag.quadratic_n_s2_per_m2),
    )


def body_on_ground(rotor_count: int) -> Body:
    """At rest on the ground at the origin, level, heading north, rotors stopped."""
    motion = np.zeros(13)
    motion[6] = 1.0
    return Body(motion, np.zeros(rotor_count))


@compiled
def derivative(
    frame: Airframe,
    motion: Float[Array, "13"],
    rotor_speed: Float[Array, " n"],
    rotor_acceleration: Float[Array, " n"],
    wind: Vec3,
    out: Float[Array, "13"],
) -> None:
    """Time derivative of `motion`, written to `out`; `wind` is the velocity of the air (NED, m/s)."""
    q = motion[6:10]
    wx, wy, wz = motion[10], motion[11], motion[12]
    air = to_body(q, motion[3:6] - wind)
    speed = math.sqrt(air[0] ** 2 + air[1] ** 2 + air[2] ** 2)
    force = -(frame.linear_drag + frame.quadratic_drag * speed) * air
    torque = np.zeros(3)
    spin_momentum = 0.0
    for i in range(rotor_speed.size):
        r = frame.position[i]
        omega = rotor_speed[i]
        thrust = frame.thrust_coefficient * omega**2
        drag = frame.rotor_drag * omega
        fx = -drag * (air[0] + wy * r[2] - wz * r[1])
        fy = -drag * (air[1] + wz * r[0] - wx * r[2])
        force[0] += fx
        force[1] += fy
        force[2] -= thrust
        torque[0] += -r[1] * thrust - r[2] * fy
        torque[1] += r[0] * thrust + r[2] * fx
        torque[2] += r[0] * fy - r[1] * fx
        torque[2] += frame.spin[i] * (
            frame.moment_coefficient * omega**2 + frame.rotor_inertia * rotor_acceleration[i]
        )
        spin_momentum -= frame.spin[i] * frame.rotor_inertia * omega
    acceleration = to_world(q, force / frame.mass)
    jx, jy, jz = frame.inertia[0], frame.inertia[1], frame.inertia[2]
    out[0:3] = motion[3:6]
    out[3:6] = acceleration
    out[5] += GRAVITY_M_S2
    out[6] = -0.5 * (q[1] * wx + q[2] * wy + q[3] * wz)
    out[7] = 0.5 * (q[0] * wx + q[2] * wz - q[3] * wy)
    out[8] = 0.5 * (q[0] * wy - q[1] * wz + q[3] * wx)
    out[9] = 0.5 * (q[0] * wz + q[1] * wy - q[2] * wx)
    out[10] = (torque[0] - (jz - jy) * wy * wz - wy * spin_momentum) / jx
    out[11] = (torque[1] - (jx - jz) * wx * wz + wx * spin_momentum) / jy
    out[12] = (torque[2] - (jy - jx) * wx * wy) / jz


@compiled
def advance(frame: Airframe, body: Body, commanded_speed: Float[Array, " n"], wind: Vec3, dt: float) -> None:
    """One step of `dt` (s): exact motor lag, classical Runge-Kutta motion, ground contact."""
    lag = 1.0 - math.exp(-dt / frame.time_constant)
    rotor_acceleration = np.empty_like(body.rotor_speed)
    for i in range(body.rotor_speed.size):
        change = lag * (commanded_speed[i] - body.rotor_speed[i])
        rotor_acceleration[i] = change / dt
        body.rotor_speed[i] += change

    x = body.motion
    k = np.empty((4, 13))
    derivative(frame, x, body.rotor_speed, rotor_acceleration, wind, k[0])
    derivative(frame, x + 0.5 * dt * k[0], body.rotor_speed, rotor_acceleration, wind, k[1])
    derivative(frame, x + 0.5 * dt * k[1], body.rotor_speed, rotor_acceleration, wind, k[2])
    derivative(frame, x + dt * k[2], body.rotor_speed, rotor_acceleration, wind, k[3])
    for i in range(13):
        x[i] += dt / 6.0 * (k[0, i] + 2.0 * k[1, i] + 2.0 * k[2, i] + k[3, i])
    normalise(x[6:10])
    if x[2] >= 0.0:
        rest_on_ground(x, dt)


@compiled
def rest_on_ground(motion: Float[Array, "13"], dt: float) -> None:
    """Contact without bounce or slip, in place: the velocity is lost, the vehicle levels on its legs."""
    motion[2] = 0.0
    motion[3:6] = 0.0
    motion[10:13] = 0.0
    keep = math.exp(-dt / _LEVELLING_TIME_S)
    motion[7] *= keep
    motion[8] *= keep
    normalise(motion[6:10])
