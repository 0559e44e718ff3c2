"""Clients of other makers and the simulated vehicle: a test for each feature, for every pair that has it.

The tests of a pair share a vehicle and go on from wherever it is, because connecting anew for each would take
minutes. What a client cannot do or is refused comes from its process as an xmlrpc.client.Fault, which fails
the test; what it then knows of the vehicle is asserted, mostly by `until`. docs/peers.md is made of their
outcomes.
"""

import json
import math
from collections.abc import Iterator, Sequence
from pathlib import Path

import pytest
from peer_client import Client, Place
from peering import (
    ARDUPILOT,
    DRONEKIT,
    MAVPROXY,
    MAVSDK,
    PYMAVLINK,
    Pair,
    client,
    distance_m,
    free_system_id,
    moved,
    offered_by,
    port_of,
    until,
    vehicle,
)

pytestmark = pytest.mark.realtime

HEIGHT_M = 4.0
NEAR_M = 0.8
ROUNDING_M = 0.5  # DroneKit's degrees have single precision
PARAMETERS = {"px4": ("MPC_XY_VEL_MAX", "MIS_TAKEOFF_ALT"), "ardupilot": ("WPNAV_SPEED", "RTL_ALT")}


@pytest.fixture(scope="session")
def peer(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Iterator[Client]:
    pair: Pair = request.param
    folder = tmp_path_factory.mktemp(str(pair))
    system_id = free_system_id(pair.autopilot)
    with (
        vehicle(pair.autopilot, system_id, folder),
        client(pair.client, port_of(pair.autopilot, system_id), folder) as peer,
    ):
        yield peer


def on_the_ground(peer: Client) -> None:
    if peer.armed():
        peer.land()
        until(peer.armed, lambda armed: not armed, "disarmed after landing")


def in_the_air(peer: Client) -> None:
    if not peer.armed():
        rise(peer)


def rise(peer: Client) -> None:
    peer.arm()
    peer.take_off(HEIGHT_M)
    until(peer.place, lambda place: abs(place[2] - HEIGHT_M) < NEAR_M, "at height")


@offered_by(MAVSDK | PYMAVLINK | MAVPROXY | DRONEKIT)
def test_connect(peer: Client, request: pytest.FixtureRequest) -> None:
    pair: Pair = request.node.callspec.params["peer"]
    assert peer.autopilot() == pair.autopilot
    assert peer.system_id() != 1  # which clients assume when they know no better


@offered_by(MAVSDK | PYMAVLINK | (DRONEKIT & ARDUPILOT))
def test_ready_to_arm(peer: Client) -> None:
    until(peer.ready, bool, "ready to arm")


@offered_by(MAVSDK | PYMAVLINK | MAVPROXY | DRONEKIT)
def test_arm_and_disarm(peer: Client) -> None:
    on_the_ground(peer)
    peer.arm()
    until(peer.armed, bool, "armed")
    peer.disarm()
    until(peer.armed, lambda armed: not armed, "disarmed")


@offered_by(MAVSDK | PYMAVLINK | MAVPROXY | DRONEKIT)
def test_takeoff(peer: Client) -> None:
    on_the_ground(peer)
    rise(peer)


@offered_by(MAVSDK | PYMAVLINK | MAVPROXY | (DRONEKIT & ARDUPILOT))
def test_goto(peer: Client) -> None:
    in_the_air(peer)
    there = moved(peer.place(), north_m=6.0, east_m=-3.0)
    peer.go_to(there)
    until(peer.place, lambda place: distance_m(place, there) < NEAR_M, f"at {there}")


@offered_by(MAVSDK | PYMAVLINK | DRONEKIT)
def test_position_setpoints(peer: Client) -> None:
    in_the_air(peer)
    latitude_deg, longitude_deg, _ = peer.home()
    there = moved((latitude_deg, longitude_deg, 0.0), north_m=2.0, east_m=3.0, up_m=HEIGHT_M + 1.0)
    peer.stream_position([2.0, 3.0, -HEIGHT_M - 1.0])
    until(peer.place, lambda place: distance_m(place, there) < NEAR_M, f"at {there}")
    peer.stop_stream()


@offered_by(MAVSDK | PYMAVLINK | DRONEKIT)
def test_velocity_setpoints(peer: Client) -> None:
    in_the_air(peer)
    start = peer.place()
    peer.stream_velocity([0.0, 2.0, 0.0])
    place = until(peer.place, lambda place: distance_m(place, start) > 6.0, "6 m on")
    assert distance_m(place, moved(start, east_m=distance_m(place, start))) < 2.0
    peer.stop_stream()


@offered_by(MAVSDK | PYMAVLINK | MAVPROXY | DRONEKIT)
def test_land(peer: Client) -> None:
    in_the_air(peer)
    peer.land()
    until(peer.armed, lambda armed: not armed, "disarmed after landing")
    assert abs(peer.place()[2]) < NEAR_M


@offered_by(MAVSDK | PYMAVLINK | MAVPROXY | (DRONEKIT & ARDUPILOT))
def test_return_home(peer: Client) -> None:
    on_the_ground(peer)
    start = peer.place()
    rise(peer)
    away = moved(start, north_m=4.0, up_m=HEIGHT_M)
    peer.go_to(away)
    until(peer.place, lambda place: distance_m(place, away) < NEAR_M, f"at {away}")
    peer.return_home()
    until(peer.armed, lambda armed: not armed, "disarmed after the return")
    assert distance_m(peer.place(), start) < NEAR_M


@offered_by(MAVSDK | PYMAVLINK | (MAVPROXY & ARDUPILOT) | DRONEKIT)
def test_mode(peer: Client, request: pytest.FixtureRequest) -> None:
    in_the_air(peer)
    pair: Pair = request.node.callspec.params["peer"]
    hold = "HOLD" if pair.client == "mavsdk" else "LOITER"
    peer.set_mode(hold)
    until(peer.mode, lambda mode: mode == hold, hold)


@offered_by(MAVSDK | PYMAVLINK | MAVPROXY | DRONEKIT)
def test_status_text(peer: Client) -> None:
    on_the_ground(peer)
    peer.arm()
    until(peer.texts, lambda texts: any("rm" in text for text in texts), "a text about arming")
    peer.disarm()


def around_home(peer: Client, height_m: float) -> list[Place]:
    """The corners of a square of 10 m whose middle is home."""
    home = (*peer.home()[:2], height_m)
    return [moved(home, north_m=north, east_m=east) for north, east in ((5, 5), (5, -5), (-5, -5), (-5, 5))]


def assert_same(found: Sequence[Place], sent: Sequence[Place]) -> None:
    assert len(found) == len(sent)
    for one, other in zip(found, sent, strict=True):
        assert distance_m(one, other) < ROUNDING_M


@offered_by(MAVSDK | PYMAVLINK | MAVPROXY | DRONEKIT)
def test_all_parameters(peer: Client) -> None:
    parameters = peer.parameters()
    assert set(PARAMETERS[peer.autopilot()]) <= set(parameters)
    assert all(math.isfinite(value) for value in parameters.values())


@offered_by(MAVSDK | PYMAVLINK | MAVPROXY | DRONEKIT)
def test_set_parameter(peer: Client) -> None:
    name = PARAMETERS[peer.autopilot()][0]
    before = peer.parameter(name)
    peer.set_parameter(name, before + 1.0)
    until(lambda: peer.parameter(name), lambda value: math.isclose(value, before + 1.0), f"the new {name}")
    peer.set_parameter(name, before)
    until(lambda: peer.parameter(name), lambda value: math.isclose(value, before), f"the old {name}")


@offered_by(MAVSDK | PYMAVLINK | MAVPROXY | (DRONEKIT & ARDUPILOT))
def test_mission_both_ways(peer: Client) -> None:
    waypoints = around_home(peer, 6.0)
    peer.upload(waypoints)
    assert_same(peer.download(), waypoints)


@offered_by(MAVSDK | PYMAVLINK | MAVPROXY | (DRONEKIT & ARDUPILOT))
def test_mission_flown(peer: Client) -> None:
    in_the_air(peer)
    waypoints = around_home(peer, 5.0)[:3]
    peer.upload(waypoints)
    peer.start_mission()
    until(peer.items_done, lambda done: 0 < done < len(waypoints), "progress")
    until(peer.items_done, lambda done: done >= len(waypoints), "the last waypoint")
    until(peer.place, lambda place: distance_m(place, waypoints[-1]) < 2 * NEAR_M, "at the last waypoint")


@offered_by(MAVSDK | PYMAVLINK | MAVPROXY | (DRONEKIT & ARDUPILOT))
def test_mission_cleared(peer: Client) -> None:
    peer.upload(around_home(peer, 6.0))
    peer.clear_mission()
    until(peer.download, lambda items: not items, "no mission")


@offered_by(MAVSDK | PYMAVLINK | MAVPROXY)
def test_fence_both_ways(peer: Client) -> None:
    corners = [moved(corner, up_m=-corner[2]) for corner in around_home(peer, 0.0)]
    peer.upload_fence(corners)
    assert_same(peer.download_fence(), corners)
    peer.clear_fence()
    until(peer.download_fence, lambda found: not found, "no fence")


@offered_by(MAVSDK | PYMAVLINK | MAVPROXY)
def test_rally_points_both_ways(peer: Client) -> None:
    places = around_home(peer, 20.0)[:2]
    peer.upload_rally_points(places)
    assert_same(peer.download_rally_points(), places)


def plan_item(number: int, command: int, place: Place) -> dict[str, object]:
    return {
        "type": "SimpleItem",
        "autoContinue": True,
        "command": command,
        "doJumpId": number,
        "frame": 3,
        "params": [0, 0, 0, None, *place],
        "AMSLAltAboveTerrain": None,
        "Altitude": place[2],
        "AltitudeMode": 1,
    }


@offered_by(MAVSDK)
def test_plan_file(peer: Client, tmp_path: Path) -> None:
    corners = around_home(peer, 6.0)
    items = [plan_item(1, 22, corners[0]), *(plan_item(2 + i, 16, each) for i, each in enumerate(corners))]
    home = peer.home()
    plan = {
        "fileType": "Plan",
        "version": 1,
        "groundStation": "QGroundControl",
        "mission": {
            "version": 2,
            "firmwareType": 12,
            "vehicleType": 2,
            "cruiseSpeed": 15,
            "hoverSpeed": 5,
            "globalPlanAltitudeMode": 1,
            "plannedHomePosition": list(home),
            "items": items,
        },
        "geoFence": {
            "version": 2,
            "circles": [],
            "polygons": [{"version": 1, "inclusion": True, "polygon": [list(moved(c)[:2]) for c in corners]}],
        },
        "rallyPoints": {"version": 2, "points": [list(corners[0])]},
    }
    path = tmp_path / "square.plan"
    path.write_text(json.dumps(plan))
    peer.upload_file(str(path))
    assert len(peer.download_fence()) == len(corners)
    assert_same(peer.download_rally_points(), corners[:1])


@offered_by((MAVSDK - ARDUPILOT) | PYMAVLINK | MAVPROXY)
def test_waypoint_file(peer: Client, tmp_path: Path) -> None:
    waypoints = around_home(peer, 6.0)
    home = [(*peer.home()[:2], 0.0)] if peer.autopilot() == "ardupilot" else []
    lines = [
        f"{seq}\t{int(seq == 0)}\t3\t16\t0\t0\t0\t0\t{place[0]:.7f}\t{place[1]:.7f}\t{place[2]}\t1"
        for seq, place in enumerate([*home, *waypoints])
    ]
    path = tmp_path / "square.waypoints"
    path.write_text("\n".join(["QGC WPL 110", *lines, ""]))
    peer.upload_file(str(path))
    assert_same(peer.download(), waypoints)


@offered_by(MAVPROXY)
def test_log_of_the_link(peer: Client) -> None:
    until(
        peer.logged, lambda kinds: {"HEARTBEAT", "GLOBAL_POSITION_INT"} <= set(kinds), "telemetry in the log"
    )
