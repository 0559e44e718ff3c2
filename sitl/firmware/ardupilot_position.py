"""ArduPilot's position controller: desired state and estimate to a lean and a throttle, 400 Hz.

Position P with a square-root limit, velocity PID, horizontally to an acceleration that a lean gives,
vertically through an acceleration PID to the throttle (`libraries/AC_AttitudeControl/AC_PosControl.cpp`).
NED, SI; throttle is a fraction of the full thrust.
"""

import math
from typing import NamedTuple

import numpy as np
from jaxtyping import Float

from sitl.arrays import Array, Vec3
from sitl.compiled import compiled
from sitl.firmware.ardupilot_parameters import ArduPilotParameters
from sitl.firmware.ardupilot_path import Path
from sitl.firmware.ardupilot_pid import (
    PidGains,
    PidState,
    PlanePidState,
    reset_pid,
    update_pid,
    update_pid_xy,
)
from sitl.firmware.ardupilot_shaping import (
    clip,
    inverse_sqrt_controller,
    limit_across_first,
    limit_length,
    sqrt_controller,
)
from sitl.vehicle import GRAVITY_M_S2

_LEAST_MAX_LEAN = math.radians(10.0)
_HOVER_SHARE_OF_THRUST = 0.8
"""Leaning may take the vertical thrust to this share of the full one."""


class PositionGains(NamedTuple):
    """Gains; limits of the corrections (m/s, m/s²), of the lean (rad), and its time constant (s)."""

    position_p: float
    velocity: PidGains
    height_p: float
    climb: PidGains
    throttle: PidGains
    speed: float
    up: float
    down: float
    acceleration: float
    vertical_acceleration: float
    max_lean: float
    lean_time: float


class PositionState(NamedTuple):
    """Memory of the controller, in place.

    Attributes:
        velocity, climb, throttle: of the PIDs.
        wanted: commanded acceleration (m/s²).
        scalars: throttle before the boost for lean, throttle of hovering, largest lean that keeps the height.
    """

    velocity: PlanePidState
    climb: PidState
    throttle: PidState
    wanted: Vec3
    scalars: Float[Array, "3"]


def position_gains(p: ArduPilotParameters) -> PositionGains:
    """Gains from ArduPilot parameters."""
    return PositionGains(
        position_p=p.PSC_POSXY_P,
        velocity=PidGains(
            p=p.PSC_VELXY_P,
            i=p.PSC_VELXY_I,
            d=p.PSC_VELXY_D,
            feed_forward=p.PSC_VELXY_FF,
            i_max=0.01 * p.PSC_VELXY_IMAX,
            error_hz=p.PSC_VELXY_FLTE,
            derivative_hz=p.PSC_VELXY_FLTD,
        ),
        height_p=p.PSC_POSZ_P,
        climb=PidGains(
            p=p.PSC_VELZ_P, i=p.PSC_VELZ_I, i_max=0.01 * p.PSC_VELZ_IMAX, error_hz=p.PSC_VELZ_FLTE
        ),
        # The output is in thousandths of the throttle, the input in cm/s².
        throttle=PidGains(
            p=0.1 * p.PSC_ACCZ_P,
            i=0.1 * p.PSC_ACCZ_I,
            d=0.1 * p.PSC_ACCZ_D,
            i_max=max(0.001 * p.PSC_ACCZ_IMAX, p.MOT_THST_HOVER),
            error_hz=p.PSC_ACCZ_FLTE,
            derivative_hz=p.PSC_ACCZ_FLTD,
        ),
        speed=0.01 * p.WPNAV_SPEED,
        up=0.01 * p.WPNAV_SPEED_UP,
        down=0.01 * p.WPNAV_SPEED_DN,
        acceleration=0.01 * p.WPNAV_ACCEL,
        vertical_acceleration=0.01 * p.WPNAV_ACCEL_Z,
        max_lean=math.radians(p.PSC_ANGLE_MAX or 0.01 * p.ANGLE_MAX),
        lean_time=p.ATC_ANG_LIM_TC,
    )


def position_state(hover_throttle: float) -> PositionState:
    """At rest, nothing integrated."""
    scalars = np.array((0.0, hover_throttle, 0.5 * math.pi))
    return PositionState(np.zeros((3, 2)), np.zeros(4), np.zeros(4), np.zeros(3), scalars)


@compiled
def begin_position(
    gains: PositionGains, state: PositionState, now: Path, position: Vec3, velocity: Vec3, measured: float
) -> None:
    """Begin at the estimate: the path here and at this speed, integrals that keep lean and throttle.

    `measured` is the vertical acceleration, down.
    """
    most = gains.vertical_acceleration
    for axis in range(3):
        now.position[axis] = position[axis]
        now.velocity[axis] = velocity[axis]
        now.limit[axis] = 0.0
        now.position_error[axis] = 0.0
        now.velocity_error[axis] = 0.0
    for axis in range(2):
        now.acceleration[axis] = 0.0
        state.velocity[0, axis] = 0.0
        state.velocity[1, axis] = 0.0
        state.velocity[2, axis] = state.wanted[axis]
    now.acceleration[2] = state.wanted[2] = clip(measured, -most, most)
    reset_pid(state.climb, velocity[2], velocity[2])
    state.climb[3] = 0.0
    reset_pid(state.throttle, state.wanted[2], measured)
    state.throttle[3] = -(state.scalars[0] - state.scalars[1]) - gains.throttle.p * (
        state.wanted[2] - measured
    )


@compiled
def control_horizontal(
    gains: PositionGains, state: PositionState, now: Path, position: Vec3, velocity: Vec3, dt: float
) -> None:
    """Commanded north and east acceleration; the path is pulled along where the vehicle is too far behind."""
    farthest = inverse_sqrt_controller(gains.speed, gains.position_p, gains.acceleration)
    x, y = limit_length(now.position[0] - position[0], now.position[1] - position[1], farthest)
    now.position[0], now.position[1] = position[0] + x, position[1] + y
    now.position_error[0], now.position_error[1] = x, y
    distance = math.hypot(x, y)
    speed = sqrt_controller(distance, gains.position_p, gains.acceleration, 0.0)
    scale = speed / distance if distance > 0.0 else 0.0
    wanted_velocity = (now.velocity[0] + scale * x, now.velocity[1] + scale * y)
    wanted_x, wanted_y = update_pid_xy(
        gains.velocity,
        state.velocity,
        wanted_velocity,
        (velocity[0], velocity[1]),
        (now.limit[0], now.limit[1]),
        dt,
    )
    now.velocity_error[0], now.velocity_error[1] = state.velocity[0, 0], state.velocity[0, 1]
    wanted_x += now.acceleration[0]
    wanted_y += now.acceleration[1]
    most = GRAVITY_M_S2 * math.tan(min(max(state.scalars[2], _LEAST_MAX_LEAN), gains.max_lean))
    direction = (now.velocity[0], now.velocity[1])
    state.wanted[0], state.wanted[1] = limit_across_first(direction, wanted_x, wanted_y, most)
    cut = math.hypot(wanted_x, wanted_y) > most
    now.limit[0] = wanted_x if cut else 0.0
    now.limit[1] = wanted_y if cut else 0.0


@compiled
def control_vertical(
    gains: PositionGains,
    state: PositionState,
    now: Path,
    height: float,
    velocity: float,
    measured: float,
    limit: float,
    dt: float,
) -> None:
    """Throttle before the boost for lean; `height`, `velocity` and `measured` acceleration point down.

    `limit` is 1 where the rotors give no less thrust, −1 where they give no more, else 0.
    """
    p, most = gains.height_p, gains.vertical_acceleration
    error = clip(
        now.position[2] - height,
        -inverse_sqrt_controller(gains.up, p, most),
        inverse_sqrt_controller(gains.down, p, most),
    )
    now.position[2] = height + error
    now.position_error[2] = error
    wanted_velocity = now.velocity[2] + sqrt_controller(error, p, most, 0.0)
    limited = limit != 0.0
    correction = update_pid(gains.climb, state.climb, wanted_velocity, velocity, limited, dt)
    now.velocity_error[2] = state.climb[1]
    state.wanted[2] = correction + now.acceleration[2]
    less = update_pid(gains.throttle, state.throttle, state.wanted[2], measured, limited, dt)
    state.scalars[0] = clip(state.scalars[1] - less, 0.0, 1.0)
    lean = math.acos(clip(state.scalars[0] / _HOVER_SHARE_OF_THRUST, 0.0, 1.0))
    state.scalars[2] += dt / (dt + gains.lean_time) * (lean - state.scalars[2])
    now.limit[2] = limit


@compiled
def learn_hover(state: PositionState, throttle: float, dt: float, time: float) -> None:
    """Move the throttle of hovering towards the present one, with the time constant `time` (s)."""
    state.scalars[1] = clip(
        state.scalars[1] + dt / (dt + time) * (throttle - state.scalars[1]), 0.125, 0.6875
    )
