"""Rigid-body dynamics of a multirotor: NED world, FRD body, flat rough ground at z = 0.

Each rotor: thrust k ω² against body z, torque ±k_m ω² about it, in-plane drag c ω v_air with the velocity of
the centre of mass through the air.
"""

import math
from typing import NamedTuple

import numpy as np
from jaxtyping import Float

from sitl.arrays import Array, Vec3
from sitl.compiled import compiled
from sitl.quaternion import normalise, rotate, rotate_back
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
    angular_drag: Vec3


class Body(NamedTuple):
    """State that `advance` moves on, in place.

    Attributes:
        motion: position (3), velocity (3), attitude (4), body rates (3); NED, SI.
        rotor_speed: rad/s.
    """

    motion: Float[Array, "13"]
    rotor_speed: Float[Array, " n"]


class RotorEffort(NamedTuple):
    """What all rotors together do to the body (FRD).

    Attributes:
        thrust: N, upwards.
        roll, pitch, yaw: moments of thrust and reaction torque (N m).
        drag: in-plane drag over the air-relative velocity (N s/m).
        drag_x, drag_y, drag_z: first moments of that drag about the centre of mass (N s).
        momentum: angular momentum about z (N m s).
    """

    thrust: float
    roll: float
    pitch: float
    yaw: float
    drag: float
    drag_x: float
    drag_y: float
    drag_z: float
    momentum: float


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
        angular_drag=np.array(vehicle.body_drag.angular_nm_s),
    )


def body_on_ground(rotor_count: int) -> Body:
    """At rest on the ground at the origin, level, heading north, rotors stopped."""
    motion = np.zeros(13)
    motion[6] = 1.0
    return Body(motion, np.zeros(rotor_count))


def body_in_flight(vehicle: Vehicle, motion: Float[Array, "13"]) -> Body:
    """In this motion, its rotors carrying its weight."""
    return Body(motion.copy(), np.full(len(vehicle.rotors.layout), vehicle.hover_speed_rad_s))


@compiled
def rotor_effort(
    frame: Airframe, rotor_speed: Float[Array, " n"], rotor_acceleration: Float[Array, " n"]
) -> RotorEffort:
    """What rotors at these speeds (rad/s) and accelerations (rad/s²) do to the body."""
    thrust, roll, pitch, yaw = 0.0, 0.0, 0.0, 0.0
    drag, drag_x, drag_y, drag_z, momentum = 0.0, 0.0, 0.0, 0.0, 0.0
    for i in range(rotor_speed.size):
        x, y, z = frame.position[i, 0], frame.position[i, 1], frame.position[i, 2]
        omega = rotor_speed[i]
        lift = frame.thrust_coefficient * omega**2
        reaction = frame.moment_coefficient * omega**2 + frame.rotor_inertia * rotor_acceleration[i]
        thrust += lift
        roll -= y * lift
        pitch += x * lift
        yaw += frame.spin[i] * reaction
        drag += frame.rotor_drag * omega
        drag_x += frame.rotor_drag * omega * x
        drag_y += frame.rotor_drag * omega * y
        drag_z += frame.rotor_drag * omega * z
        momentum -= frame.spin[i] * frame.rotor_inertia * omega
    return RotorEffort(thrust, roll, pitch, yaw, drag, drag_x, drag_y, drag_z, momentum)


@compiled
def derivative(
    frame: Airframe, motion: Float[Array, "13"], effort: RotorEffort, wind: Vec3, out: Float[Array, "13"]
) -> None:
    """Time derivative of `motion`, written to `out`; `wind` is the velocity of the air (NED, m/s)."""
    q = motion[6:10]
    wx, wy, wz = motion[10], motion[11], motion[12]
    air_x, air_y, air_z = rotate_back(q, (motion[3] - wind[0], motion[4] - wind[1], motion[5] - wind[2]))
    speed = math.sqrt(air_x**2 + air_y**2 + air_z**2)
    linear, quadratic = frame.linear_drag, frame.quadratic_drag
    force_x = -(linear[0] + quadratic[0] * speed + effort.drag) * air_x
    force_y = -(linear[1] + quadratic[1] * speed + effort.drag) * air_y
    force_z = -(linear[2] + quadratic[2] * speed) * air_z - effort.thrust
    damping = frame.angular_drag
    roll = effort.roll + effort.drag_z * air_y - damping[0] * wx
    pitch = effort.pitch - effort.drag_z * air_x - damping[1] * wy
    yaw = effort.yaw + effort.drag_y * air_x - effort.drag_x * air_y - damping[2] * wz
    north, east, down = rotate(q, (force_x, force_y, force_z))
    jx, jy, jz = frame.inertia[0], frame.inertia[1], frame.inertia[2]
    out[0] = motion[3]
    out[1] = motion[4]
    out[2] = motion[5]
    out[3] = north / frame.mass
    out[4] = east / frame.mass
    out[5] = down / frame.mass + GRAVITY_M_S2
    out[6] = -0.5 * (q[1] * wx + q[2] * wy + q[3] * wz)
    out[7] = 0.5 * (q[0] * wx + q[2] * wz - q[3] * wy)
    out[8] = 0.5 * (q[0] * wy - q[1] * wz + q[3] * wx)
    out[9] = 0.5 * (q[0] * wz + q[1] * wy - q[2] * wx)
    out[10] = (roll - (jz - jy) * wy * wz - wy * effort.momentum) / jx
    out[11] = (pitch - (jx - jz) * wx * wz + wx * effort.momentum) / jy
    out[12] = (yaw - (jy - jx) * wx * wy) / jz


@compiled
def advance(frame: Airframe, body: Body, commanded_speed: Float[Array, " n"], wind: Vec3, dt: float) -> None:
    """One step of `dt` (s): exact motor lag, classical Runge-Kutta motion, ground contact."""
    lag = 1.0 - math.exp(-dt / frame.time_constant)
    speed = body.rotor_speed
    rotor_acceleration = lag / dt * (commanded_speed - speed)
    speed += dt * rotor_acceleration
    effort = rotor_effort(frame, speed, rotor_acceleration)
    x = body.motion
    k = np.empty((4, 13))
    derivative(frame, x, effort, wind, k[0])
    if x[2] >= 0.0 and k[0, 5] >= 0.0:
        rest_on_ground(x, dt)
        return
    derivative(frame, x + 0.5 * dt * k[0], effort, wind, k[1])
    derivative(frame, x + 0.5 * dt * k[1], effort, wind, k[2])
    derivative(frame, x + dt * k[2], effort, wind, k[3])
    x += dt / 6.0 * (k[0] + 2.0 * k[1] + 2.0 * k[2] + k[3])
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
