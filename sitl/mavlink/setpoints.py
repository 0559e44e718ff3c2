"""Offboard setpoints: what PX4 makes of SET_POSITION_TARGET_LOCAL_NED (its mavlink_receiver.cpp)."""

import math

import numpy as np
from pymavlink.dialects.v20 import common as mavlink

from sitl import quaternion
from sitl.arrays import Quaternion, Vec3
from sitl.firmware.interface import Setpoint

IGNORE_BITS = (
    mavlink.POSITION_TARGET_TYPEMASK_X_IGNORE,
    mavlink.POSITION_TARGET_TYPEMASK_Y_IGNORE,
    mavlink.POSITION_TARGET_TYPEMASK_Z_IGNORE,
    mavlink.POSITION_TARGET_TYPEMASK_VX_IGNORE,
    mavlink.POSITION_TARGET_TYPEMASK_VY_IGNORE,
    mavlink.POSITION_TARGET_TYPEMASK_VZ_IGNORE,
    mavlink.POSITION_TARGET_TYPEMASK_AX_IGNORE,
    mavlink.POSITION_TARGET_TYPEMASK_AY_IGNORE,
    mavlink.POSITION_TARGET_TYPEMASK_AZ_IGNORE,
    mavlink.POSITION_TARGET_TYPEMASK_YAW_IGNORE,
    mavlink.POSITION_TARGET_TYPEMASK_YAW_RATE_IGNORE,
)
"""The mask bit of x, y, z, vx, vy, vz, afx, afy, afz, yaw, yaw_rate."""

_OFF = math.nan
_ABSURD = 1e9


class SetpointRefusedError(Exception):
    """The setpoint is not flown and is no proof of life; the message is what PX4 tells the ground."""


def read_setpoint(
    message: mavlink.MAVLink_set_position_target_local_ned_message, attitude: Quaternion
) -> Setpoint:
    """The setpoint in a message; `attitude` (body to NED) turns those in MAV_FRAME_BODY_NED.

    An axis is off when it is masked, not finite or absurd (beyond 1e9). In the body frame velocity and
    acceleration count only with all three axes, and there is no position.

    Raises:
        SetpointRefusedError: another frame, a force, or nothing but yaw.
    """
    name = message.msgname
    fields = (
        *(message.x, message.y, message.z),
        *(message.vx, message.vy, message.vz),
        *(message.afx, message.afy, message.afz),
        *(message.yaw, message.yaw_rate),
    )
    values = np.array(
        [
            value if abs(value) < _ABSURD and not message.type_mask & bit else _OFF
            for bit, value in zip(IGNORE_BITS, fields, strict=True)
        ]
    )
    position, velocity, acceleration = values[0:3], values[3:6], values[6:9]
    if message.coordinate_frame == mavlink.MAV_FRAME_BODY_NED:
        position = np.full(3, _OFF)
        velocity = quaternion.to_world(quaternion.from_yaw(quaternion.yaw_of(attitude)), velocity)
        acceleration = quaternion.to_world(attitude, acceleration)
    elif message.coordinate_frame != mavlink.MAV_FRAME_LOCAL_NED:
        raise SetpointRefusedError(f"{name} coordinate frame {message.coordinate_frame} unsupported")
    if message.type_mask & mavlink.POSITION_TARGET_TYPEMASK_FORCE_SET and _is_on(acceleration):
        raise SetpointRefusedError(f"{name} force not supported")
    if not (_is_on(position) or _is_on(velocity) or _is_on(acceleration)):
        raise SetpointRefusedError(f"{name} invalid")
    return Setpoint(position, velocity, acceleration, float(values[9]), float(values[10]))


def _is_on(channel: Vec3) -> bool:
    return not np.isnan(channel).all()
