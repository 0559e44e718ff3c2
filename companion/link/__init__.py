"""Byte transports, MAVLink framing, time sync and requests; nothing of learning."""
