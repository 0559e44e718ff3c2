"""Byte transports, MAVLink framing, time sync and requests; nothing of learning."""

from companion.link.address import parse_address
from companion.link.connecting import connect
from companion.link.connection import Connection
from companion.link.telemetry import Telemetry, start_telemetry

__all__ = ["Connection", "Telemetry", "connect", "parse_address", "start_telemetry"]
