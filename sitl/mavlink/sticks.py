"""The pilot's sticks as a ground station sends them: MANUAL_CONTROL and RC_CHANNELS_OVERRIDE."""

from typing import TYPE_CHECKING

from pymavlink.dialects.v20 import common as mavlink

from sitl.firmware.pilot import Sticks
from sitl.mavlink.frames import Message
from sitl.mavlink.telemetry import Report

if TYPE_CHECKING:
    from sitl.mavlink.session import Session

_FULL = 1000.0
_MIDDLE_US, _RANGE_US = 1500.0, 500.0
_UNUSED = (0, 65535)
_NOBODY_US = (1500, 1500, 1000, 1500, 1800, 1000, 1000, 1800, *[1000] * 8)
"""What ArduPilot's simulator receives from a transmitter that nobody holds."""
_UNKNOWN_STRENGTH = 255


def _limited(value: float) -> float:
    return min(max(value, -1.0), 1.0)


def rc_channels(state: Report) -> Message:
    """RC_CHANNELS: a transmitter that nobody holds."""
    channels = (*_NOBODY_US, *[_UNUSED[1]] * 2)
    fields = (state.time_ms, len(_NOBODY_US), *channels, _UNKNOWN_STRENGTH)
    return mavlink.MAVLink_rc_channels_message(*fields)


def _is_pilot(session: "Session", message: Message) -> bool:
    """ArduPilot lets nobody but SYSID_MYGCS move its sticks."""
    sender = message.get_srcSystem()
    return bool(getattr(session.firmware.parameters, "SYSID_MYGCS", sender) == sender)


def on_manual_control(session: "Session", message: mavlink.MAVLink_manual_control_message) -> None:
    """Forward (x), right (y), clockwise (r) from -1000 to 1000; up (z) from 0 to 1000, 500 in the middle."""
    if message.target != session.system_id or not _is_pilot(session, message):
        return
    climb = 2.0 * message.z / _FULL - 1.0
    pitch, roll, yaw = message.x / _FULL, message.y / _FULL, message.r / _FULL
    session.firmware.move_sticks(Sticks(_limited(roll), _limited(pitch), _limited(climb), _limited(yaw)))


def on_channels_override(session: "Session", message: mavlink.MAVLink_rc_channels_override_message) -> None:
    """Pulses (µs) of roll, pitch, throttle and yaw; a channel that is not overridden is in its middle."""
    is_ours = session.accepts(message.target_system, message.target_component)
    if not is_ours or not _is_pilot(session, message):
        return
    pulses = (message.chan1_raw, message.chan2_raw, message.chan3_raw, message.chan4_raw)
    roll, back, climb, yaw = (
        0.0 if pulse in _UNUSED else _limited((pulse - _MIDDLE_US) / _RANGE_US) for pulse in pulses
    )
    if any(pulse not in _UNUSED for pulse in pulses):
        session.firmware.move_sticks(Sticks(roll, -back, climb, yaw))
