"""The vehicle's state as the companion knows it: NED, SI, radians."""

from companion.state.vehicle_state import VehicleState

__all__ = ["VehicleState"]
