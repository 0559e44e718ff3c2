"""Byte transports, MAVLink framing, time sync and requests; nothing of learning."""

from companion.link.address import parse_address
from companion.link.connection import Connection, connect
from companion.link.telemetry import Telemetry, start_telemetry

__all__ = ["Connection", "Telemetry", "connect", "parse_address", "start_telemetry"]
