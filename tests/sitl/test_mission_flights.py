"""Missions, returns and fences as both simulated autopilots fly them, in virtual time."""

import math
from collections.abc import Iterable

import numpy as np
import pytest
from plan_items import HOME, command, item
from sitl_flights import in_hover, simulation, texts, with_parameters

from sitl.firmware.ardupilot_parameters import ArduPilotParameters
from sitl.firmware.ardupilot_return import return_height
from sitl.firmware.interface import Mode, Result
from sitl.plan.items import Command, Item, PlanKind
from sitl.plan.mission import MissionState
from sitl.quaternion import yaw_of
from sitl.simulation import Simulation
from sitl.vehicle import Vehicle, load_vehicle

ARDUCOPTER = load_vehicle("arducopter_sitl")
TAKEOFF = item(Command.NAV_TAKEOFF, up=5.0)
OUT = item(Command.NAV_WAYPOINT, 15.0, 0.0, 5.0)
BACK = item(Command.NAV_WAYPOINT, 0.0, 10.0, 6.0)
LAND = item(Command.NAV_LAND, 0.0, 10.0)


def arducopter(**parameters: float) -> Vehicle:
    data = ARDUCOPTER.model_dump(exclude_unset=True)
    return Vehicle.model_validate(data | {"ardupilot_parameters": parameters})


def load(sim: Simulation, *items: Item, kind: PlanKind = PlanKind.MISSION) -> None:
    sim.firmware.plans.replace(kind, items)


def mode_of(sim: Simulation) -> Mode:
    return sim.firmware.mode


def state_of(sim: Simulation) -> MissionState:
    return sim.firmware.plans.mission.state


def fly(sim: Simulation, seconds: float, *, until: MissionState | None = None) -> None:
    end_s = sim.time_s + seconds
    while sim.time_s < end_s and state_of(sim) is not until:
        sim.advance(sim.time_s + 0.1)


def flown(sim: Simulation) -> np.ndarray[tuple[int, ...], np.dtype[np.float64]]:
    return np.array([truth.position for truth in sim.truth_log])


def nearest(sim: Simulation, *place: float) -> float:
    return float(np.linalg.norm(flown(sim) - np.array(place), axis=1).min())


def start_ardupilot(*items: Item, vehicle: Vehicle = ARDUCOPTER) -> Simulation:
    sim = simulation(vehicle)
    load(sim, HOME, *items)
    assert sim.firmware.set_mode(Mode.OFFBOARD) is Result.ACCEPTED
    assert sim.firmware.arm() is Result.ACCEPTED
    assert sim.firmware.start_mission() is Result.ACCEPTED
    return sim


# PX4


def test_px4_flies_a_mission_to_its_end_and_lands() -> None:
    sim = simulation()
    load(sim, TAKEOFF, OUT, BACK, LAND)
    assert sim.firmware.start_mission() is Result.ACCEPTED
    assert mode_of(sim) is Mode.MISSION
    fly(sim, 90.0)
    assert sim.firmware.plans.mission.take_reached() == [0, 1, 2, 3]
    assert nearest(sim, 15.0, 0.0, -5.0) < 2.0
    assert not sim.firmware.armed
    assert mode_of(sim) is Mode.MISSION
    assert sim.truth.position == pytest.approx((0.0, 10.0, 0.0), abs=0.3)
    assert "Mission finished, landed" in texts(sim)


def test_px4_arms_in_mission_mode_and_takes_off_by_itself() -> None:
    sim = simulation()
    load(sim, OUT)
    assert sim.firmware.set_mode(Mode.MISSION) is Result.ACCEPTED
    assert sim.firmware.arm() is Result.ACCEPTED
    fly(sim, 40.0, until=MissionState.COMPLETE)
    fly(sim, 5.0)
    assert mode_of(sim) is Mode.MISSION
    assert "Mission finished, loitering" in texts(sim)
    assert sim.truth.position == pytest.approx((15.0, 0.0, -5.0), abs=2.5)


def test_px4_has_no_mission_mode_without_a_mission() -> None:
    sim = simulation()
    assert sim.firmware.set_mode(Mode.MISSION) is Result.TEMPORARILY_REJECTED
    assert "MISSION denied: no valid mission" in texts(sim)
    assert sim.firmware.start_mission() is Result.DENIED
    assert "No valid mission" in texts(sim)


@pytest.mark.parametrize(
    ("items", "reason"),
    [
        ((LAND,), "starts with landing"),
        ((OUT, TAKEOFF), "takeoff is not the first"),
        ((item(Command.NAV_TAKEOFF, up=-1.0),), "takeoff altitude too low"),
        ((item(Command.NAV_WAYPOINT, 20_000.0, 0.0, 5.0),), "first waypoint too far away"),
    ],
)
def test_px4_says_why_a_mission_is_not_feasible(items: tuple[Item, ...], reason: str) -> None:
    sim = simulation()
    load(sim, *items)
    assert f"Mission rejected: {reason}" in texts(sim)
    assert sim.firmware.set_mode(Mode.MISSION) is Result.TEMPORARILY_REJECTED


def test_px4_takes_off_again_after_a_landing_amid_the_mission() -> None:
    sim = simulation()
    load(sim, TAKEOFF, OUT, item(Command.NAV_LAND, 15.0), item(Command.NAV_WAYPOINT, 15.0, 5.0, 4.0))
    sim.firmware.start_mission()
    fly(sim, 90.0, until=MissionState.COMPLETE)
    assert sim.firmware.armed
    assert "Landing detected" in texts(sim)
    assert sim.truth.position == pytest.approx((15.0, 5.0, -4.0), abs=2.5)


def test_px4_ends_the_flight_beyond_a_fence_that_asks_for_it() -> None:
    sim = in_hover(with_parameters(GF_ACTION=4, GF_MAX_VER_DIST=1.0))
    assert not sim.firmware.armed
    assert "Geofence violation: altitude, TERMINATE" in texts(sim)


@pytest.mark.parametrize(("mode", "heading_deg"), [(0, 0.0), (1, 180.0), (2, 0.0)])
def test_px4_looks_where_it_is_told(mode: int, heading_deg: float) -> None:
    sim = simulation(with_parameters(MPC_YAW_MODE=mode))
    load(sim, TAKEOFF, OUT)
    sim.firmware.start_mission()
    fly(sim, 40.0, until=MissionState.COMPLETE)
    fly(sim, 4.0)
    assert abs(math.remainder(yaw_of(sim.truth.attitude) - math.radians(heading_deg), math.tau)) < 0.3


@pytest.mark.parametrize("autopilot", ["px4", "ardupilot"])
def test_a_region_of_interest_is_looked_at(autopilot: str) -> None:
    east = item(Command.DO_SET_ROI_LOCATION, 15.0, 40.0)
    if autopilot == "ardupilot":
        sim = start_ardupilot(TAKEOFF, east, OUT)
    else:
        sim = simulation()
        load(sim, TAKEOFF, east, OUT)
        sim.firmware.start_mission()
    fly(sim, 40.0, until=MissionState.COMPLETE)
    assert yaw_of(sim.truth.attitude) == pytest.approx(math.pi / 2.0, abs=0.3)


def test_px4_goes_on_after_a_pause() -> None:
    sim = simulation()
    load(sim, TAKEOFF, OUT, BACK)
    sim.firmware.start_mission()
    fly(sim, 7.0)
    assert sim.firmware.plans.mission.current == 1
    assert sim.firmware.set_mode(Mode.HOLD) is Result.ACCEPTED
    fly(sim, 4.0)
    assert state_of(sim) is MissionState.PAUSED
    assert sim.truth.velocity == pytest.approx((0.0, 0.0, 0.0), abs=0.05)
    assert sim.firmware.set_mode(Mode.MISSION) is Result.ACCEPTED
    fly(sim, 30.0, until=MissionState.COMPLETE)
    assert sim.firmware.plans.mission.take_reached() == [0, 1, 2]


def test_px4_flies_at_the_speed_that_the_mission_says() -> None:
    sim = simulation()
    slow = command(Command.DO_CHANGE_SPEED, 1.0, 1.5, -1.0)
    load(sim, TAKEOFF, slow, OUT)
    sim.firmware.start_mission()
    fly(sim, 40.0, until=MissionState.COMPLETE)
    speeds = [math.hypot(truth.velocity[0], truth.velocity[1]) for truth in sim.truth_log]
    assert max(speeds) == pytest.approx(1.5, abs=0.2)


def test_px4_lands_at_the_nearest_rally_point() -> None:
    sim = in_hover(with_parameters(RTL_RETURN_ALT=6.0))
    load(sim, item(Command.RALLY_POINT, 12.0, 12.0), item(Command.RALLY_POINT, -90.0), kind=PlanKind.RALLY)
    sim.firmware.reposition(np.array((14.0, 10.0, -4.0)), math.nan)
    fly(sim, 15.0)
    sim.firmware.set_mode(Mode.RTL)
    fly(sim, 40.0)
    assert sim.truth.position == pytest.approx((12.0, 12.0, 0.0), abs=0.4)
    assert not sim.firmware.armed


def test_px4_waits_over_home_before_it_lands() -> None:
    sim = in_hover(with_parameters(RTL_RETURN_ALT=5.0, RTL_DESCEND_ALT=3.0, RTL_LAND_DELAY=8.0))
    sim.firmware.reposition(np.array((14.0, 0.0, -3.0)), math.nan)
    fly(sim, 15.0)
    sim.firmware.set_mode(Mode.RTL)
    fly(sim, 14.0)
    assert sim.truth.position == pytest.approx((0.0, 0.0, -3.0), abs=0.4)
    fly(sim, 30.0)
    assert not sim.firmware.armed


@pytest.mark.parametrize(("action", "mode"), [(1, Mode.HOLD), (2, Mode.HOLD), (3, Mode.RTL), (5, Mode.LAND)])
def test_px4_minds_its_fence(action: int, mode: Mode) -> None:
    sim = in_hover(with_parameters(GF_ACTION=action, GF_MAX_HOR_DIST=8.0, RTL_RETURN_ALT=4.0))
    sim.firmware.reposition(np.array((30.0, 0.0, -2.5)), math.nan)
    fly(sim, 4.5)
    assert sim.firmware.fence_status.breach == "distance"
    assert mode_of(sim) is mode
    assert "Geofence violation: distance" in texts(sim)
    fly(sim, 5.0)
    assert (float(sim.truth.position[0]) > 20.0) == (action == 1)


def test_px4_ignores_a_fence_without_action_and_a_pilot_may_overrule_it() -> None:
    sim = in_hover(with_parameters(GF_ACTION=0, GF_MAX_VER_DIST=1.0))
    assert sim.firmware.fence_status.breach == ""
    sim.firmware.set_parameter("GF_ACTION", 3)
    fly(sim, 0.5)
    assert mode_of(sim) is Mode.RTL
    assert sim.firmware.set_mode(Mode.HOLD) is Result.ACCEPTED
    fly(sim, 2.0)
    assert mode_of(sim) is Mode.HOLD
    assert sim.firmware.fence_status.count == 1


def test_px4_refuses_a_mission_beyond_the_fence() -> None:
    sim = simulation()
    load(sim, item(Command.FENCE_INCLUSION_CIRCLE, params=(10.0, 0.0, 0.0, 0.0)), kind=PlanKind.FENCE)
    load(sim, TAKEOFF, OUT)
    assert "geofence violation for waypoint 2" in texts(sim)
    assert sim.firmware.start_mission() is Result.DENIED
    load(sim, kind=PlanKind.FENCE)
    assert sim.firmware.start_mission() is Result.ACCEPTED


# ArduPilot


def test_ardupilot_flies_a_mission_to_its_end_and_lands() -> None:
    sim = start_ardupilot(TAKEOFF, OUT, BACK, LAND)
    seen = set[MissionState]()
    for _ in range(900):
        sim.advance(sim.time_s + 0.1)
        seen.add(state_of(sim))
    assert sim.firmware.plans.mission.take_reached()[:3] == [1, 2, 3]
    assert MissionState.ACTIVE in seen
    assert nearest(sim, 15.0, 0.0, -5.0) < 2.0
    assert not sim.firmware.armed
    assert sim.truth.position == pytest.approx((0.0, 10.0, 0.0), abs=0.6)


def test_ardupilot_returns_at_the_end_of_a_mission_and_stays_in_auto() -> None:
    sim = start_ardupilot(
        TAKEOFF,
        OUT,
        command(Command.NAV_RETURN_TO_LAUNCH),
        vehicle=arducopter(RTL_ALT=800, RTL_LOIT_TIME=1000),
    )
    modes = set[Mode]()
    for _ in range(700):
        sim.advance(sim.time_s + 0.1)
        modes.add(mode_of(sim))
    assert modes == {Mode.MISSION}
    assert not sim.firmware.armed
    assert -flown(sim)[:, 2].min() == pytest.approx(8.0, abs=0.3)
    assert sim.truth.position == pytest.approx((0.0, 0.0, 0.0), abs=0.6)


def test_ardupilot_stays_down_in_auto_until_the_mission_is_started() -> None:
    sim = simulation(ARDUCOPTER)
    load(sim, HOME, TAKEOFF, OUT)
    sim.firmware.set_mode(Mode.OFFBOARD)
    sim.firmware.arm()
    assert sim.firmware.set_mode(Mode.MISSION) is Result.ACCEPTED
    fly(sim, 4.0)
    assert sim.truth.position[2] == 0.0
    assert sim.firmware.start_mission() is Result.ACCEPTED
    fly(sim, 8.0)
    assert sim.truth.position[2] < -4.0


@pytest.mark.parametrize(
    ("items", "reason"), [((), "no mission"), ((HOME,), "no mission"), ((HOME, OUT), "Missing Takeoff Cmd")]
)
def test_ardupilot_refuses_auto_and_says_why(items: Iterable[Item], reason: str) -> None:
    sim = simulation(ARDUCOPTER)
    load(sim, *items)
    sim.firmware.set_mode(Mode.OFFBOARD)
    sim.firmware.arm()
    assert sim.firmware.set_mode(Mode.MISSION) is Result.FAILED
    assert reason in texts(sim)


@pytest.mark.parametrize(("options", "result"), [(0, Result.FAILED), (1, Result.ACCEPTED)])
def test_ardupilot_arms_in_auto_if_it_may(options: int, result: Result) -> None:
    sim = simulation(arducopter(AUTO_OPTIONS=options))
    load(sim, HOME, TAKEOFF)
    assert sim.firmware.set_mode(Mode.MISSION) is Result.ACCEPTED
    assert sim.firmware.arm() is result


def test_ardupilot_flies_round_a_place() -> None:
    circle = item(Command.NAV_LOITER_TURNS, 15.0, 0.0, 5.0, (1.0, 0.0, 5.0, 0.0))
    sim = start_ardupilot(TAKEOFF, circle)
    fly(sim, 60.0, until=MissionState.COMPLETE)
    assert sim.firmware.plans.mission.take_reached() == [1, 2]
    distance = np.hypot(*(flown(sim)[-1500:, :2] - np.array((15.0, 0.0))).T)
    assert distance == pytest.approx(5.0, abs=1.0)
    assert nearest(sim, 20.0, 0.0, -5.0) < 1.0


def test_ardupilot_hovers_where_a_mission_ends() -> None:
    sim = start_ardupilot(TAKEOFF, OUT)
    fly(sim, 60.0, until=MissionState.COMPLETE)
    fly(sim, 8.0)
    assert mode_of(sim) is Mode.MISSION
    assert sim.truth.velocity == pytest.approx((0.0, 0.0, 0.0), abs=0.1)


@pytest.mark.parametrize(
    ("action", "mode"), [(0, Mode.OFFBOARD), (1, Mode.RTL), (2, Mode.LAND), (4, Mode.BRAKE)]
)
def test_ardupilot_minds_its_fence(action: int, mode: Mode) -> None:
    sim = in_hover(arducopter(FENCE_ENABLE=1, FENCE_ACTION=action, FENCE_RADIUS=30.0))
    sim.firmware.reposition(np.array((60.0, 0.0, -2.5)), math.nan)
    fly(sim, 9.0)
    assert sim.firmware.fence_status.breach == "distance"
    assert mode_of(sim) is mode
    assert "Circle fence breached" in texts(sim)


def test_ardupilots_floor_counts_once_it_was_passed_until_the_landing() -> None:
    floor = {"FENCE_ENABLE": 1, "FENCE_TYPE": 8, "FENCE_ALT_MIN": 1.0, "FENCE_MARGIN": 1.0}
    sim = in_hover(arducopter(**floor, FENCE_ACTION=2))
    assert sim.firmware.fence_status.count == 0
    sim.firmware.reposition(np.array((0.0, 0.0, -0.7)), math.nan)
    fly(sim, 5.0)
    assert sim.firmware.fence_status.count == 1
    assert mode_of(sim) is Mode.LAND
    fly(sim, 15.0)
    assert sim.firmware.fence_status.breach == ""
    assert sim.firmware.fence_status.count == 1
    assert not sim.firmware.armed


def test_ardupilots_fence_is_off_until_it_is_enabled() -> None:
    sim = in_hover(arducopter(FENCE_ALT_MAX=10.0))
    sim.firmware.reposition(np.array((0.0, 0.0, -14.0)), math.nan)
    fly(sim, 12.0)
    assert mode_of(sim) is Mode.OFFBOARD
    assert sim.firmware.enable_fence(enabled=True) is Result.ACCEPTED
    fly(sim, 1.0)
    assert mode_of(sim) is Mode.RTL
    assert "Altitude fence breached" in texts(sim)


@pytest.mark.parametrize(
    ("parameters", "place_up", "height"),
    [
        ({}, 0.0, 15.0),
        ({"RTL_ALT": 800}, 12.0, 12.0),
        ({"RTL_CONE_SLOPE": 0.6}, 0.0, 12.0),
        ({"RTL_CONE_SLOPE": 0.4}, 0.0, 15.0),
        ({"FENCE_ENABLE": 1, "FENCE_ALT_MAX": 14.0, "FENCE_MARGIN": 3.0}, 0.0, 11.0),
        ({"RTL_ALT": 300, "RTL_CLIMB_MIN": 400}, 0.0, 9.0),
    ],
)
def test_ardupilot_returns_as_high_as_it_must(
    parameters: dict[str, float], place_up: float, height: float
) -> None:
    values = ArduPilotParameters.model_validate(parameters)
    place, here = np.array((20.0, 0.0, -place_up)), np.array((0.0, 0.0, -5.0))
    assert return_height(values, place, here, np.zeros(3)) == pytest.approx(height)


def test_ardupilot_counts_what_is_on_board() -> None:
    sim = simulation(ARDUCOPTER)
    load(sim, HOME, TAKEOFF, OUT)
    load(sim, item(Command.RALLY_POINT, 12.0), kind=PlanKind.RALLY)
    counts = sim.firmware.parameters.model_dump(include={"MIS_TOTAL", "RALLY_TOTAL", "FENCE_TOTAL"})
    assert counts == {"MIS_TOTAL": 3, "RALLY_TOTAL": 1, "FENCE_TOTAL": 0}
