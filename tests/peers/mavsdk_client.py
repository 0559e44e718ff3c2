"""MAVSDK, through its Python package."""

import json
import math
import sys
from collections.abc import Sequence

from mavsdk import Autopilot, ComponentType, Configuration, ConnectionResult, Mavsdk
from mavsdk.plugins.action import Action
from mavsdk.plugins.geofence import Geofence, GeofenceData, Point, Polygon
from mavsdk.plugins.mavlink_direct import MavlinkDirect, MavlinkMessage
from mavsdk.plugins.mission import Mission, MissionItem, MissionPlan
from mavsdk.plugins.mission_raw import MissionItem as RawItem
from mavsdk.plugins.mission_raw import MissionRaw
from mavsdk.plugins.offboard import Offboard, PositionNedYaw, VelocityNedYaw
from mavsdk.plugins.param import Param
from mavsdk.plugins.telemetry import Telemetry
from peer_client import Place
from peer_server import PATIENCE_S, serve, wait_until

_WAYPOINT, _RALLY_POINT, _RELATIVE_ALTITUDE_INT = 16, 5100, 6
_RATE_HZ = 10.0
_GUIDED = 4
_AUTOPILOTS = {Autopilot.PX4: "px4", Autopilot.ARDUPILOT: "ardupilot"}


class MavsdkClient:
    def __init__(self, port: int) -> None:
        self._mavsdk = Mavsdk(Configuration.create_with_component_type(ComponentType.GROUND_STATION))
        result = self._mavsdk.add_any_connection(f"udpin://127.0.0.1:{port}")
        if result != ConnectionResult.SUCCESS:
            raise ConnectionError(result.name)
        system = self._mavsdk.first_autopilot(PATIENCE_S)
        if system is None:
            raise TimeoutError("no autopilot found")
        self._system = system
        self._action, self._telemetry, self._offboard = Action(system), Telemetry(system), Offboard(system)
        self._params, self._fence = Param(system), Geofence(system)
        self._direct = MavlinkDirect(system)
        self._mission, self._raw = Mission(system), MissionRaw(system)
        self._is_ardupilot = self.autopilot() == "ardupilot"
        if self._is_ardupilot:  # silent until asked
            self._telemetry.set_rate_position(_RATE_HZ)
            self._telemetry.set_rate_health(_RATE_HZ)
        self._texts: list[str] = []
        self._telemetry.subscribe_status_text(lambda text, _: self._texts.append(text.text))

    def autopilot(self) -> str:
        return _AUTOPILOTS[self._system.autopilot_type()]

    def system_id(self) -> int:
        return int(self._system.get_system_id())

    def ready(self) -> bool:
        return bool(self._telemetry.health_all_ok())

    def mode(self) -> str:
        return str(self._telemetry.flight_mode().name)

    def set_mode(self, name: str) -> None:
        {"HOLD": self._action.hold, "RETURN_TO_LAUNCH": self._action.return_to_launch}[name]()

    def arm(self) -> None:
        if self._is_ardupilot:  # after a landing it is in LAND, and MAVSDK's hold, BRAKE, cannot be armed in
            self._enter_guided()
        self._action.arm()

    def _enter_guided(self) -> None:
        system_id = self._system.get_system_id()
        fields = json.dumps({"target_system": system_id, "base_mode": 1, "custom_mode": _GUIDED})
        self._direct.send_message(MavlinkMessage("SET_MODE", target_system_id=system_id, fields_json=fields))
        wait_until(lambda: self.mode() == "OFFBOARD", "GUIDED, which MAVSDK calls OFFBOARD")

    def disarm(self) -> None:
        self._action.disarm()

    def armed(self) -> bool:
        return bool(self._telemetry.armed())

    def take_off(self, height_m: float) -> None:
        self._action.set_takeoff_altitude(height_m)
        self._action.takeoff()

    def place(self) -> Place:
        position = self._telemetry.position()
        return position.latitude_deg, position.longitude_deg, position.relative_altitude_m

    def go_to(self, place: Place) -> None:
        latitude_deg, longitude_deg, height_m = place
        self._action.goto_location(latitude_deg, longitude_deg, self.home()[2] + height_m, math.nan)

    def stream_position(self, ned: Sequence[float]) -> None:
        self._offboard.set_position_ned(PositionNedYaw(*ned, 0.0))
        self._offboard.start()

    def stream_velocity(self, ned: Sequence[float]) -> None:
        self._offboard.set_velocity_ned(VelocityNedYaw(*ned, 0.0))
        self._offboard.start()

    def stop_stream(self) -> None:
        self._offboard.stop()

    def return_home(self) -> None:
        self._action.return_to_launch()

    def land(self) -> None:
        self._action.land()

    def texts(self) -> list[str]:
        return self._texts

    def parameters(self) -> dict[str, float]:
        found = self._params.get_all_params()
        return {each.name: float(each.value) for each in (*found.int_params, *found.float_params)}

    def parameter(self, name: str) -> float:
        return float(self._params.get_param_float(name))

    def set_parameter(self, name: str, value: float) -> None:
        self._params.set_param_float(name, value)

    def home(self) -> Place:
        wait_until(lambda: self._telemetry.health().is_home_position_ok, "home known")
        home = self._telemetry.home()
        return home.latitude_deg, home.longitude_deg, home.absolute_altitude_m

    # The Mission plugin cannot read ArduPilot's first item, home, so MissionRaw does there.

    def upload(self, waypoints: Sequence[Place]) -> None:
        if self._is_ardupilot:
            home = (*self.home()[:2], 0.0)
            self._raw.upload_mission(_raw_items([home, *waypoints], _WAYPOINT, mission_type=0))
        else:
            items = [MissionItem(*waypoint, is_fly_through=True) for waypoint in waypoints]
            self._mission.upload_mission(MissionPlan(items))

    def download(self) -> list[Place]:
        if self._is_ardupilot:
            return [_place(item) for item in self._raw.download_mission()[1:]]
        items = self._mission.download_mission().mission_items
        return [(item.latitude_deg, item.longitude_deg, item.relative_altitude_m) for item in items]

    def start_mission(self) -> None:
        (self._raw if self._is_ardupilot else self._mission).start_mission()

    def items_done(self) -> int:
        if self._is_ardupilot:
            return int(self._raw.mission_progress().current) - 1
        return int(self._mission.mission_progress().current)

    def clear_mission(self) -> None:
        self._raw.clear_mission()

    def upload_file(self, path: str) -> None:
        if not path.endswith(".plan"):
            self._raw.upload_mission(self._raw.import_mission_planner_mission(path).mission_items)
            return
        plan = self._raw.import_qgroundcontrol_mission(path)
        self._raw.upload_mission(plan.mission_items)
        self._raw.upload_geofence(plan.geofence_items)
        self._raw.upload_rally_points(plan.rally_items)

    def upload_fence(self, corners: Sequence[Place]) -> None:
        points = [Point(latitude_deg, longitude_deg) for latitude_deg, longitude_deg, _ in corners]
        self._fence.upload_geofence(GeofenceData(polygons=[Polygon(points)]))

    def download_fence(self) -> list[Place]:
        polygons = self._fence.download_geofence().polygons
        return [(point.latitude_deg, point.longitude_deg, 0.0) for each in polygons for point in each.points]

    def clear_fence(self) -> None:
        self._fence.clear_geofence()

    def upload_rally_points(self, places: Sequence[Place]) -> None:
        self._raw.upload_rally_points(_raw_items(places, _RALLY_POINT, mission_type=2))

    def download_rally_points(self) -> list[Place]:
        return [_place(item) for item in self._raw.download_rallypoints()]


def _raw_items(places: Sequence[Place], command: int, *, mission_type: int) -> list[RawItem]:
    return [
        RawItem(
            seq=seq,
            frame=_RELATIVE_ALTITUDE_INT,
            command=command,
            current=int(seq == 0),
            autocontinue=1,
            x=round(latitude_deg * 1e7),
            y=round(longitude_deg * 1e7),
            z=height_m,
            mission_type=mission_type,
        )
        for seq, (latitude_deg, longitude_deg, height_m) in enumerate(places)
    ]


def _place(item: RawItem) -> Place:
    return item.x * 1e-7, item.y * 1e-7, item.z


if __name__ == "__main__":
    serve(MavsdkClient(int(sys.argv[1])))
