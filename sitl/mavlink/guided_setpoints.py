"""GUIDED setpoints: what ArduPilot makes of SET_POSITION_TARGET_LOCAL_NED (its GCS_MAVLink_Copter.cpp)."""

import math

import numpy as np
from pymavlink.dialects.v20 import common as mavlink

from sitl import quaternion
from sitl.arrays import Vec3
from sitl.firmware.interface import Estimate, Setpoint

_IGNORE_POSITION = (
    mavlink.POSITION_TARGET_TYPEMASK_X_IGNORE
    | mavlink.POSITION_TARGET_TYPEMASK_Y_IGNORE
    | mavlink.POSITION_TARGET_TYPEMASK_Z_IGNORE
)
_IGNORE_VELOCITY = (
    mavlink.POSITION_TARGET_TYPEMASK_VX_IGNORE
    | mavlink.POSITION_TARGET_TYPEMASK_VY_IGNORE
    | mavlink.POSITION_TARGET_TYPEMASK_VZ_IGNORE
)
_IGNORE_ACCELERATION = (
    mavlink.POSITION_TARGET_TYPEMASK_AX_IGNORE
    | mavlink.POSITION_TARGET_TYPEMASK_AY_IGNORE
    | mavlink.POSITION_TARGET_TYPEMASK_AZ_IGNORE
)
_BODY_FRAMES = (mavlink.MAV_FRAME_BODY_NED, mavlink.MAV_FRAME_BODY_OFFSET_NED)
_OFFSET_FRAMES = (*_BODY_FRAMES, mavlink.MAV_FRAME_LOCAL_OFFSET_NED)
_FRAMES = (*_OFFSET_FRAMES, mavlink.MAV_FRAME_LOCAL_NED)
_FASTEST = 1000.0
"""m/s on an axis: what is beyond is taken for an error."""


def stop() -> Setpoint:
    """What a message that GUIDED does not take amounts to."""
    return Setpoint(velocity=np.zeros(3))


def read_guided_setpoint(
    message: mavlink.MAVLink_set_position_target_local_ned_message, estimate: Estimate
) -> Setpoint:
    """The setpoint in a message; `estimate` turns and moves those in frames of the body.

    A channel is off as a whole when one of its axes is masked. Taken are a position, a velocity, both, each
    of the latter two with an acceleration, and an acceleration alone; anything else stops the vehicle.
    """
    mask, frame = message.type_mask, message.coordinate_frame
    position = None if mask & _IGNORE_POSITION else np.array([message.x, message.y, message.z])
    velocity = None if mask & _IGNORE_VELOCITY else np.array([message.vx, message.vy, message.vz])
    acceleration = None if mask & _IGNORE_ACCELERATION else np.array([message.afx, message.afy, message.afz])
    force = mask & mavlink.POSITION_TARGET_TYPEMASK_FORCE_SET and acceleration is not None
    if frame not in _FRAMES or force or not _is_taken(position, velocity, acceleration):
        return stop()
    heading = quaternion.yaw_of(estimate.attitude)
    if frame in _BODY_FRAMES:
        position, velocity, acceleration = (
            None if channel is None else quaternion.to_world(quaternion.from_yaw(heading), channel)
            for channel in (position, velocity, acceleration)
        )
    if frame in _OFFSET_FRAMES and position is not None:
        position = position + estimate.position
    yaw, yaw_rate = _heading(message)
    return Setpoint(
        _or_off(position),
        _or_off(velocity),
        _or_off(acceleration),
        yaw + heading if frame in _BODY_FRAMES else yaw,
        yaw_rate,
    )


def _heading(message: mavlink.MAVLink_set_position_target_local_ned_message) -> tuple[float, float]:
    """Yaw (rad) and its rate (rad/s); NaN where masked or not finite."""
    fields = (
        (mavlink.POSITION_TARGET_TYPEMASK_YAW_IGNORE, message.yaw),
        (mavlink.POSITION_TARGET_TYPEMASK_YAW_RATE_IGNORE, message.yaw_rate),
    )
    yaw, yaw_rate = (
        math.nan if message.type_mask & bit or not math.isfinite(value) else value for bit, value in fields
    )
    return yaw, yaw_rate


def _is_taken(position: Vec3 | None, velocity: Vec3 | None, acceleration: Vec3 | None) -> bool:
    """Whether GUIDED has a controller for these channels, and their numbers make sense."""
    channels = [channel for channel in (position, velocity, acceleration) if channel is not None]
    if not channels or not all(np.isfinite(channel).all() for channel in channels):
        return False
    if velocity is None:
        return position is None or acceleration is None
    return bool(np.abs(velocity).max() <= _FASTEST)


def _or_off(channel: Vec3 | None) -> Vec3:
    return np.full(3, math.nan) if channel is None else channel
