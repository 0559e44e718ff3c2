"""The MAVLink dialect that is spoken, with its generated message classes.

Beside the common messages: ArduPilot's, and CURRENT_MODE, which PX4 sends although it is in development.
"""

from pymavlink.dialects.v20 import all as mavlink

Message = mavlink.MAVLink_message

__all__ = ["Message", "mavlink"]
