"""The MAVLink dialect that is spoken, common and what ArduPilot adds, with its generated message classes."""

from pymavlink.dialects.v20 import ardupilotmega as mavlink

Message = mavlink.MAVLink_message

__all__ = ["Message", "mavlink"]
