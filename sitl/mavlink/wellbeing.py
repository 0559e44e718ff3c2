"""What the vehicle tells of its clock, its mode, its estimator and its vibrations."""

import math
from typing import cast

from pymavlink.dialects.v20 import common as mavlink
from pymavlink.dialects.v20.ardupilotmega import MAVLink_ekf_status_report_message
from pymavlink.dialects.v20.development import MAVLink_current_mode_message

from sitl.estimator import CONTENT
from sitl.mavlink.frames import Message
from sitl.mavlink.telemetry import Report

EKF_STATUS_REPORT: int = MAVLink_ekf_status_report_message.id
_NON_STANDARD_MODE = 0
_BOOT_US = 1_767_225_600_000_000
"""Unix time at which every simulation boots: the first second of 2026."""
_WITHOUT_POSITION = (
    mavlink.ESTIMATOR_ATTITUDE
    | mavlink.ESTIMATOR_VELOCITY_VERT
    | mavlink.ESTIMATOR_POS_VERT_ABS
    | mavlink.ESTIMATOR_CONST_POS_MODE
)
_WITH_POSITION = (
    mavlink.ESTIMATOR_ATTITUDE
    | mavlink.ESTIMATOR_VELOCITY_HORIZ
    | mavlink.ESTIMATOR_VELOCITY_VERT
    | mavlink.ESTIMATOR_POS_HORIZ_REL
    | mavlink.ESTIMATOR_POS_HORIZ_ABS
    | mavlink.ESTIMATOR_POS_VERT_ABS
    | mavlink.ESTIMATOR_PRED_POS_HORIZ_REL
    | mavlink.ESTIMATOR_PRED_POS_HORIZ_ABS
)


def _flags(state: Report) -> int:
    return _WITH_POSITION if state.position_ok else _WITHOUT_POSITION


def system_time(state: Report) -> Message:
    """SYSTEM_TIME: a date that does not depend on when the simulation runs, and the time since boot."""
    return mavlink.MAVLink_system_time_message(_BOOT_US + state.time_us, state.time_ms)


def current_mode(state: Report) -> Message:
    """CURRENT_MODE: the mode alone, at whatever rate a peer likes, and the one that somebody chose."""
    modes, firmware = state.flavour.custom_modes, state.firmware
    message = MAVLink_current_mode_message(
        _NON_STANDARD_MODE, modes[firmware.mode], intended_custom_mode=modes[firmware.intended_mode]
    )
    return cast(Message, message)  # pymavlink gives each dialect a base class of its own


def vibration(state: Report) -> Message:
    """VIBRATION: none."""
    return mavlink.MAVLink_vibration_message(state.time_us, 0.0, 0.0, 0.0, 0, 0, 0)


def estimator_status(state: Report) -> Message:
    """ESTIMATOR_STATUS: which estimates may be trusted; PX4's."""
    velocity_ratio, heading_ratio = state.firmware.estimate.test_ratios
    return mavlink.MAVLink_estimator_status_message(
        time_usec=state.time_us,
        flags=_flags(state),
        vel_ratio=velocity_ratio,
        pos_horiz_ratio=CONTENT,
        pos_vert_ratio=CONTENT,
        mag_ratio=heading_ratio,
        hagl_ratio=CONTENT,
        tas_ratio=math.nan,
        pos_horiz_accuracy=0.3,
        pos_vert_accuracy=0.3,
    )


def ekf_status_report(state: Report) -> Message:
    """EKF_STATUS_REPORT: the same for ArduPilot, whose flags have the same bits."""
    velocity_ratio, heading_ratio = state.firmware.estimate.test_ratios
    message = MAVLink_ekf_status_report_message(
        flags=_flags(state),
        velocity_variance=velocity_ratio,
        pos_horiz_variance=CONTENT,
        pos_vert_variance=CONTENT,
        compass_variance=heading_ratio,
        terrain_alt_variance=0.0,
    )
    return cast(Message, message)  # pymavlink gives each dialect a base class of its own
