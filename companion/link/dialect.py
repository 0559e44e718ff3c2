"""The MAVLink dialect that is spoken, with the message classes that pymavlink generated for it."""

from pymavlink.dialects.v20 import common as mavlink

Message = mavlink.MAVLink_message

__all__ = ["Message", "mavlink"]
