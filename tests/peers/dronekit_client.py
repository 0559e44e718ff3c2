"""DroneKit, as its maintained fork dronekit2 has it."""

import sys
import threading
from collections.abc import Sequence
from typing import Any

from dronekit import Command, LocationGlobalRelative, Vehicle, VehicleMode, connect
from peer_client import Place
from peer_server import PATIENCE_S, serve, wait_until
from pymavlink.dialects.v20 import common as mavlink

_SETPOINT_PERIOD_S = 0.05
_POSITION_ONLY, _VELOCITY_ONLY = 3576, 3527
_AUTOPILOTS = {
    mavlink.MAV_AUTOPILOT_PX4: "px4",
    mavlink.MAV_AUTOPILOT_ARDUPILOTMEGA: "ardupilot",
}


class DronekitClient:
    def __init__(self, port: int) -> None:
        self._vehicle = connect(f"udpin:127.0.0.1:{port}", wait_ready=True, timeout=PATIENCE_S)
        self._texts: list[str] = []
        self._vehicle.add_message_listener(
            "STATUSTEXT", lambda vehicle, name, message: self._texts.append(message.text)
        )
        self._reached = 0
        self._vehicle.add_message_listener("MISSION_ITEM_REACHED", self._on_reached)
        self._streaming = threading.Event()

    def _on_reached(self, vehicle: Vehicle, name: str, message: Any) -> None:
        self._reached = message.seq

    def autopilot(self) -> str:
        return _AUTOPILOTS[self._vehicle.version.autopilot_type]

    def system_id(self) -> int:
        return int(self._vehicle._handler.target_system)

    def ready(self) -> bool:
        return bool(self._vehicle.is_armable)

    def mode(self) -> str:
        return str(self._vehicle.mode.name)

    def set_mode(self, name: str) -> None:
        self._vehicle.mode = VehicleMode(name)
        self._vehicle.wait_for_mode(name, timeout=PATIENCE_S)

    def arm(self) -> None:
        if self.autopilot() == "ardupilot":  # after a landing it is in LAND
            self.set_mode("GUIDED")
        self._vehicle.arm(timeout=PATIENCE_S)

    def disarm(self) -> None:
        self._vehicle.disarm(timeout=PATIENCE_S)

    def armed(self) -> bool:
        return bool(self._vehicle.armed)

    def take_off(self, height_m: float) -> None:
        if self.autopilot() == "px4":  # which takes an altitude above the sea in that command, and a place
            self.set_parameter("MIS_TAKEOFF_ALT", height_m)
            self.set_mode("TAKEOFF")
        else:
            self._vehicle.simple_takeoff(height_m)

    def place(self) -> Place:
        location = self._vehicle.location.global_relative_frame
        return location.lat, location.lon, location.alt

    def go_to(self, place: Place) -> None:
        self.set_mode("GUIDED")
        self._vehicle.simple_goto(LocationGlobalRelative(*place))

    def stream_position(self, ned: Sequence[float]) -> None:
        self._stream(_POSITION_ONLY, [*ned, 0.0, 0.0, 0.0])

    def stream_velocity(self, ned: Sequence[float]) -> None:
        self._stream(_VELOCITY_ONLY, [0.0, 0.0, 0.0, *ned])

    def _stream(self, mask: int, position_velocity: Sequence[float]) -> None:
        self._streaming.set()
        self._streaming = streaming = threading.Event()
        setpoint = self._vehicle.message_factory.set_position_target_local_ned_encode(
            0, 0, 0, mavlink.MAV_FRAME_LOCAL_NED, mask, *position_velocity, *[0.0] * 5
        )

        def send_on() -> None:
            while not streaming.wait(_SETPOINT_PERIOD_S):
                self._vehicle.send_mavlink(setpoint)

        self._vehicle.send_mavlink(setpoint)  # PX4 wants one before it changes to OFFBOARD
        threading.Thread(target=send_on, daemon=True).start()
        self.set_mode({"px4": "OFFBOARD", "ardupilot": "GUIDED"}[self.autopilot()])

    def stop_stream(self) -> None:
        self.set_mode("LOITER")
        self._streaming.set()

    def return_home(self) -> None:
        self.set_mode("RTL")

    def land(self) -> None:
        self.set_mode("LAND")

    def texts(self) -> list[str]:
        return self._texts

    def parameters(self) -> dict[str, float]:
        self._vehicle.parameters.wait_ready()
        return dict(self._vehicle.parameters)

    def parameter(self, name: str) -> float:
        return float(self._vehicle.parameters[name])

    def set_parameter(self, name: str, value: float) -> None:
        self._vehicle.parameters[name] = value

    def home(self) -> Place:
        if self._vehicle.home_location is None:  # ArduPilot's first mission item
            self._fetch_mission()
        wait_until(lambda: self._vehicle.home_location, "home")
        home = self._vehicle.home_location
        return home.lat, home.lon, home.alt

    def _fetch_mission(self) -> None:
        self._vehicle.commands.download()
        self._vehicle.commands.wait_ready(timeout=PATIENCE_S)

    def upload(self, waypoints: Sequence[Place]) -> None:
        self._fetch_mission()  # keeps the home item
        commands = self._vehicle.commands
        commands.clear()
        for place in waypoints:
            frame = mavlink.MAV_FRAME_GLOBAL_RELATIVE_ALT
            command = mavlink.MAV_CMD_NAV_WAYPOINT
            commands.add(Command(0, 0, 0, frame, command, 0, 0, 0, 0, 0, 0, *place))
        commands.upload(timeout=PATIENCE_S)

    def download(self) -> list[Place]:
        self._fetch_mission()
        return [(item.x, item.y, item.z) for item in self._vehicle.commands]

    def start_mission(self) -> None:
        self._reached = 0
        self.set_mode("AUTO")

    def items_done(self) -> int:
        return self._reached

    def clear_mission(self) -> None:
        self._vehicle.commands.clear()
        self._vehicle.commands.upload(timeout=PATIENCE_S)


if __name__ == "__main__":
    serve(DronekitClient(int(sys.argv[1])))
