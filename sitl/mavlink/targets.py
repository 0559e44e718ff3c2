"""What the vehicle tells of what it follows: POSITION_TARGET_LOCAL_NED, ATTITUDE_TARGET, the outputs."""

import math

from pymavlink.dialects.v20 import common as mavlink

from sitl.mavlink.frames import Message
from sitl.mavlink.setpoints import IGNORE_BITS
from sitl.mavlink.telemetry import Report

_DISARMED_US = 900
_IDLE_US = 1000
_RANGE_US = 1000
_SERVOS = 16


def position_target_local_ned(state: Report) -> Message:
    """POSITION_TARGET_LOCAL_NED: what the position controller follows; channels that are off are masked."""
    setpoint = state.firmware.active_setpoint
    values = [
        *setpoint.position.tolist(),
        *setpoint.velocity.tolist(),
        *setpoint.acceleration.tolist(),
        setpoint.yaw,
        setpoint.yaw_rate,
    ]
    mask = sum(bit for bit, value in zip(IGNORE_BITS, values, strict=True) if not math.isfinite(value))
    return mavlink.MAVLink_position_target_local_ned_message(
        state.time_ms, mavlink.MAV_FRAME_LOCAL_NED, mask, *values
    )


def attitude_target(state: Report) -> Message:
    """ATTITUDE_TARGET: what the attitude and the rate controller follow."""
    target = state.firmware.attitude_target
    roll_rate, pitch_rate, yaw_rate = target.rates.tolist()
    return mavlink.MAVLink_attitude_target_message(
        state.time_ms, 0, target.attitude.tolist(), roll_rate, pitch_rate, yaw_rate, target.thrust
    )


def servo_output_raw(state: Report) -> Message:
    """SERVO_OUTPUT_RAW: the pulses of the rotors (µs), as if each gave the mean thrust."""
    pulse = _IDLE_US + round(_RANGE_US * state.firmware.attitude_target.thrust)
    rotors = [pulse if state.firmware.armed else _DISARMED_US] * state.rotors
    return mavlink.MAVLink_servo_output_raw_message(
        state.time_us % 2**32, 0, *rotors, *[_DISARMED_US] * (_SERVOS - state.rotors)
    )
