"""Attitude as seen facing north: what the learned models are given, whatever way the nose points."""

import numpy as np

from companion.arrays import Vec3


def facing_north(attitude: Vec3, rates: Vec3, yaw_setpoint: float) -> tuple[Vec3, Vec3]:
    """Roll, pitch and rates as they would read at yaw 0, so that one model serves every heading.

    The tilt of the thrust axis is kept exactly; body rates are turned about the vertical by the yaw, which
    is exact when level. The third angle becomes the yaw error.

    Args:
        attitude: roll, pitch, yaw (rad), z-y'-x'' from NED.
        rates: body rates p, q, r (rad/s).
        yaw_setpoint: the yaw that the autopilot was asked to hold (rad).

    Returns:
        Attitude (roll, pitch, yaw error; rad) and rates (rad/s).
    """
    roll, pitch, yaw = attitude
    sin_yaw, cos_yaw = np.sin(yaw), np.cos(yaw)
    # Third column of R = Rz(yaw) Ry(pitch) Rx(roll): the body's down axis in NED.
    forward, right = np.cos(roll) * np.sin(pitch), -np.sin(roll)
    down_n = cos_yaw * forward - sin_yaw * right
    down_e = sin_yaw * forward + cos_yaw * right
    down_d = np.cos(roll) * np.cos(pitch)
    yaw_error = float(np.remainder(yaw - yaw_setpoint + np.pi, 2.0 * np.pi) - np.pi)
    levelled = np.array([-np.arcsin(np.clip(down_e, -1.0, 1.0)), np.arctan2(down_n, down_d), yaw_error])
    p, q, r = rates
    return levelled, np.array([cos_yaw * p - sin_yaw * q, sin_yaw * p + cos_yaw * q, r])
