"""The MAVLink face of the simulated vehicle: what makes it a PX4 or ArduPilot vehicle for MAVLink clients."""

from sitl.mavlink.links import GROUND_STATION, OFFBOARD, TELEMETRY, Link
from sitl.mavlink.vehicle import Delivery, MavlinkVehicle, open_vehicle

__all__ = ["GROUND_STATION", "OFFBOARD", "TELEMETRY", "Delivery", "Link", "MavlinkVehicle", "open_vehicle"]
