"""A script with pymavlink: mavutil for the link and the simple commands, mavwp for mission files."""

import math
import sys
import threading
from collections.abc import Sequence
from typing import Any

from mavutil_link import MavutilLink
from mavutil_missions import clear, download, place_of, upload, waypoint
from peer_client import Place
from peer_server import serve, wait_until
from pymavlink import mavwp
from pymavlink.dialects.v20 import common as mavlink

_SETPOINT_PERIOD_S = 0.05
_POSITION_ONLY, _VELOCITY_ONLY = 3576, 3527
_MISSION, _FENCE, _RALLY = range(3)
_EVERYTHING, _RATE_HZ = 0, 10


class PymavlinkClient(MavutilLink):
    def __init__(self, port: int) -> None:
        super().__init__(f"udpin:127.0.0.1:{port}")
        self._autopilot = self.autopilot()
        self._streaming = threading.Event()
        if self._autopilot == "ardupilot":
            self._mav.request_data_stream_send(*self._target, _EVERYTHING, _RATE_HZ, 1)

    def home(self) -> Place:
        if self._autopilot == "ardupilot":
            wait_until(self._asked_for_home, "home")
        return super().home()

    def _asked_for_home(self) -> bool:
        """ArduPilot tells it when asked; on a bad link the question may be lost."""
        if not self.has("HOME_POSITION"):
            self._mav.command_long_send(*self._target, mavlink.MAV_CMD_GET_HOME_POSITION, 0, *[0.0] * 7)
        return self.has("HOME_POSITION")

    @property
    def _mav(self) -> Any:
        return self.connection.mav

    @property
    def _target(self) -> tuple[int, int]:
        return self.connection.target_system, mavlink.MAV_COMP_ID_AUTOPILOT1

    def _command(self, command: int, *params: float) -> None:
        self.forget_answers()
        self._mav.command_long_send(*self._target, command, 0, *params, *[0.0] * (7 - len(params)))
        self._expect_accepted(command)

    def _expect_accepted(self, command: int) -> None:
        name = mavlink.enums["MAV_CMD"][command].name
        while (answer := self.answer("COMMAND_ACK")) and answer.command != command:
            pass
        if answer is None:
            raise TimeoutError(f"no answer to {name}")
        if answer.result != mavlink.MAV_RESULT_ACCEPTED:
            raise RuntimeError(f"{name}: {mavlink.enums['MAV_RESULT'][answer.result].name}")

    def ready(self) -> bool:
        healthy = self.newest("SYS_STATUS").onboard_control_sensors_health
        return bool(healthy & mavlink.MAV_SYS_STATUS_PREARM_CHECK)

    def set_mode(self, name: str) -> None:
        self.connection.set_mode(name)
        wait_until(lambda: self.mode() == name, f"mode {name}")

    def arm(self) -> None:
        if self._autopilot == "ardupilot":  # after a landing it is in LAND
            self.set_mode("GUIDED")
        self.forget_answers()
        self.connection.arducopter_arm()  # whatever its name says
        self._expect_accepted(mavlink.MAV_CMD_COMPONENT_ARM_DISARM)

    def disarm(self) -> None:
        self.forget_answers()
        self.connection.arducopter_disarm()
        self._expect_accepted(mavlink.MAV_CMD_COMPONENT_ARM_DISARM)

    def take_off(self, height_m: float) -> None:
        if self._autopilot == "px4":
            altitude_m = self.home()[2] + height_m
            self._command(mavlink.MAV_CMD_NAV_TAKEOFF, 0.0, 0.0, 0.0, *[math.nan] * 3, altitude_m)
        else:
            self._command(mavlink.MAV_CMD_NAV_TAKEOFF, *[0.0] * 6, height_m)

    def go_to(self, place: Place) -> None:
        latitude_deg, longitude_deg, height_m = place
        self.forget_answers()
        self._mav.command_int_send(
            *self._target,
            mavlink.MAV_FRAME_GLOBAL,
            mavlink.MAV_CMD_DO_REPOSITION,
            0,
            0,
            -1.0,
            mavlink.MAV_DO_REPOSITION_FLAGS_CHANGE_MODE,
            0.0,
            math.nan,
            round(latitude_deg * 1e7),
            round(longitude_deg * 1e7),
            self.home()[2] + height_m,
        )
        self._expect_accepted(mavlink.MAV_CMD_DO_REPOSITION)

    def stream_position(self, ned: Sequence[float]) -> None:
        self._stream(_POSITION_ONLY, [*ned, 0.0, 0.0, 0.0])

    def stream_velocity(self, ned: Sequence[float]) -> None:
        self._stream(_VELOCITY_ONLY, [0.0, 0.0, 0.0, *ned])

    def _stream(self, mask: int, position_velocity: Sequence[float]) -> None:
        self._streaming.set()
        self._streaming = streaming = threading.Event()

        def send() -> None:
            self._mav.set_position_target_local_ned_send(
                0, *self._target, mavlink.MAV_FRAME_LOCAL_NED, mask, *position_velocity, *[0.0] * 5
            )

        def send_on() -> None:
            while not streaming.wait(_SETPOINT_PERIOD_S):
                send()

        send()  # PX4 wants one before it changes to OFFBOARD
        threading.Thread(target=send_on, daemon=True).start()
        self.set_mode({"px4": "OFFBOARD", "ardupilot": "GUIDED"}[self._autopilot])

    def stop_stream(self) -> None:
        self.set_mode("LOITER")
        self._streaming.set()

    def return_home(self) -> None:
        self.connection.set_mode_rtl()

    def land(self) -> None:
        self._command(mavlink.MAV_CMD_NAV_LAND, 0.0, 0.0, 0.0, math.nan)

    def parameters(self) -> dict[str, float]:
        received = self.received_parameters
        received.clear()
        self.connection.param_fetch_all()
        wait_until(
            lambda: received and len(received) >= next(iter(received.values())).param_count, "every parameter"
        )
        return {name: self.connection.param(name) for name in received}

    def parameter(self, name: str) -> float:
        self.received_parameters.pop(name, None)
        self.connection.param_fetch_one(name)
        wait_until(lambda: name in self.received_parameters, name)
        return float(self.connection.param(name))

    def set_parameter(self, name: str, value: float) -> None:
        self.received_parameters.pop(name, None)
        self.connection.param_set_send(name, value)
        wait_until(lambda: name in self.received_parameters, f"an answer to {name} = {value:g}")

    def upload(self, waypoints: Sequence[Place]) -> None:
        places = [self._home_item(), *waypoints] if self._autopilot == "ardupilot" else waypoints
        items = [waypoint(self, place, mavlink.MAV_CMD_NAV_WAYPOINT, _MISSION) for place in places]
        upload(self, items, _MISSION)

    def _home_item(self) -> Place:
        latitude_deg, longitude_deg, _ = self.home()
        return latitude_deg, longitude_deg, 0.0

    def download(self) -> list[Place]:
        items = download(self, _MISSION)
        return [place_of(item) for item in items[self._autopilot == "ardupilot" :]]

    def start_mission(self) -> None:
        self.connection.set_mode({"px4": "MISSION", "ardupilot": "AUTO"}[self._autopilot])

    def items_done(self) -> int:
        return int(self.newest("MISSION_ITEM_REACHED").seq) + (self._autopilot == "px4")

    def clear_mission(self) -> None:
        clear(self, _MISSION)

    def upload_file(self, path: str) -> None:
        loader = mavwp.MAVWPLoader(*self._target)
        loader.load(path)
        items = [waypoint(self, (item.x, item.y, item.z), item.command, _MISSION) for item in loader.wpoints]
        upload(self, items, _MISSION)

    def upload_fence(self, corners: Sequence[Place]) -> None:
        corner = mavlink.MAV_CMD_NAV_FENCE_POLYGON_VERTEX_INCLUSION
        upload(self, [waypoint(self, each, corner, _FENCE, len(corners)) for each in corners], _FENCE)

    def download_fence(self) -> list[Place]:
        return [place_of(item) for item in download(self, _FENCE)]

    def clear_fence(self) -> None:
        clear(self, _FENCE)

    def upload_rally_points(self, places: Sequence[Place]) -> None:
        point = mavlink.MAV_CMD_NAV_RALLY_POINT
        upload(self, [waypoint(self, each, point, _RALLY) for each in places], _RALLY)

    def download_rally_points(self) -> list[Place]:
        return [place_of(item) for item in download(self, _RALLY)]


if __name__ == "__main__":
    serve(PymavlinkClient(int(sys.argv[1])))
