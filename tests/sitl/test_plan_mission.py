import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from plan_items import HOME, command, item

from sitl.arrays import Vec3
from sitl.plan.items import Command, Item, Plan
from sitl.plan.mission import Flight, Leg, Mission, MissionRules, MissionState, Situation

PX4 = MissionRules(first=0, waypoint_params=True, reports_every_item=True, climbs_first=True)
ARDUPILOT = MissionRules(first=1, waypoint_params=False, reports_every_item=False, climbs_first=False)
WAYPOINT, TAKEOFF, LAND = Command.NAV_WAYPOINT, Command.NAV_TAKEOFF, Command.NAV_LAND


class Flown:
    """A mission whose vehicle is wherever it is told to go after a second."""

    def __init__(self, *items: Item, rules: MissionRules = PX4) -> None:
        self.done: list[Item] = []
        self.mission = Mission(rules, self.done.append)
        self.mission.load(Plan(items), 0)
        self.legs: list[Leg] = []
        self.time_s = 0.0
        self.position: Vec3 = np.zeros(3)
        self.yaw = 0.0
        self.landed = True

    def step(self) -> Leg | None:
        now = Situation(
            self.time_s, self.position, self.yaw, np.zeros(3), self.landed, radius=2.0, height=0.8
        )
        leg = self.mission.update(now)
        self.time_s += 1.0
        if leg is not None:
            self.legs.append(leg)
            self.position = leg.place
            self.landed = leg.flight is Flight.LAND
            self.yaw = self.yaw if math.isnan(leg.yaw) else leg.yaw
        return leg

    def fly(self, steps: int = 50) -> list[Flight]:
        for _ in range(steps):
            self.step()
        return [leg.flight for leg in self.legs]


def test_takes_off_flies_over_waypoints_and_lands() -> None:
    flown = Flown(item(TAKEOFF, up=5.0), item(WAYPOINT, 10.0, 0.0, 5.0), item(LAND, 10.0, 0.0))
    states = [flown.mission.state]
    assert flown.fly() == [Flight.CLIMB, Flight.GO, Flight.LAND]
    assert flown.mission.take_reached() == [0, 1, 2]
    assert flown.mission.take_reached() == []
    states.append(flown.mission.state)
    assert states == [MissionState.NOT_STARTED, MissionState.COMPLETE]
    assert flown.mission.current == 2
    assert flown.legs[1].place == pytest.approx((10.0, 0.0, -5.0), abs=0.02)


def test_px4_climbs_first_where_the_mission_forgot_to() -> None:
    flown = Flown(item(WAYPOINT, 10.0, 0.0, 5.0))
    assert flown.fly() == [Flight.CLIMB, Flight.GO]
    assert flown.legs[0].place == pytest.approx((0.0, 0.0, -5.0), abs=0.02)
    assert flown.mission.take_reached() == [0]


def test_a_waypoint_is_held_for_as_long_as_it_says() -> None:
    flown = Flown(item(TAKEOFF, up=5.0), item(WAYPOINT, 5.0, 0.0, 5.0, (7.0, 0.0, 0.0, math.nan)))
    flown.fly(3)
    assert flown.mission.take_reached() == [0]
    flown.fly(5)
    assert flown.mission.take_reached() == []
    flown.fly(3)
    assert flown.mission.take_reached() == [1]


def test_a_waypoint_has_its_own_radius_in_px4_alone() -> None:
    wide = item(WAYPOINT, 10.0, 0.0, 5.0, (0.0, 8.0, 0.0, math.nan))
    for rules, items, reached in ((PX4, (wide,), [0]), (ARDUPILOT, (HOME, wide), [])):
        flown = Flown(*items, rules=rules)
        flown.landed, flown.position = False, np.array((0.0, 0.0, -5.0))
        flown.step()
        flown.position = np.array((5.0, 0.0, -5.0))
        flown.step()
        assert flown.mission.take_reached() == reached


def test_a_heading_must_be_reached_too() -> None:
    flown = Flown(item(TAKEOFF, up=5.0), item(WAYPOINT, 5.0, 0.0, 5.0, (0.0, 0.0, 0.0, 90.0)))
    flown.fly(2)
    assert flown.legs[-1].yaw == pytest.approx(math.pi / 2)
    flown.yaw = 0.0
    flown.fly(3)
    assert flown.mission.current == 1
    flown.yaw = math.pi / 2 - 0.1
    flown.step()
    assert flown.mission.complete


@given(st.integers(0, 5))
def test_a_jump_is_made_as_often_as_it_says(repeat: int) -> None:
    flown = Flown(
        item(TAKEOFF, up=5.0), item(WAYPOINT, 5.0, 0.0, 5.0), command(Command.DO_JUMP, 1.0, float(repeat))
    )
    assert flown.fly().count(Flight.GO) == repeat + 1
    assert flown.mission.complete


def test_a_jump_without_end_does_not_stop_the_clock() -> None:
    flown = Flown(command(Command.DO_JUMP, 0.0, -1.0))
    assert flown.fly(3) == []
    assert not flown.mission.complete


def test_a_jump_beyond_the_mission_is_passed() -> None:
    flown = Flown(item(TAKEOFF, up=5.0), command(Command.DO_JUMP, 99.0, -1.0))
    flown.fly()
    assert flown.mission.complete


def test_commands_are_performed_and_unknown_ones_passed_over() -> None:
    speed, camera = command(Command.DO_CHANGE_SPEED, 1.0, 3.0), command(2000)
    flown = Flown(item(TAKEOFF, up=5.0), speed, camera, item(LAND))
    flown.fly()
    assert flown.done == [speed, camera]
    assert flown.mission.take_reached() == [0, 1, 2, 3]


def test_ardupilot_reports_what_is_flown_and_never_home() -> None:
    flown = Flown(HOME, item(TAKEOFF, up=5.0), command(Command.DO_CHANGE_SPEED, 1.0, 3.0), rules=ARDUPILOT)
    assert flown.mission.current == 1
    flown.fly()
    assert flown.mission.take_reached() == [1]


def test_a_mission_goes_on_where_it_was_left() -> None:
    flown = Flown(item(TAKEOFF, up=5.0), item(WAYPOINT, 90.0, 0.0, 5.0), item(LAND))
    flown.fly(2)
    flown.mission.pause()
    assert flown.mission.state is MissionState.PAUSED
    leg = flown.step()
    assert leg is not None
    assert leg.place == pytest.approx((90.0, 0.0, -5.0), abs=0.02)


def test_unlimited_loiter_never_ends_and_a_delay_does() -> None:
    flown = Flown(
        item(TAKEOFF, up=5.0), command(Command.NAV_DELAY, 4.0), item(Command.NAV_LOITER_UNLIM, up=5.0)
    )
    assert flown.fly() == [Flight.CLIMB, Flight.STAY, Flight.GO]
    assert flown.mission.take_reached() == [0, 1]


def test_circles_are_counted_in_turns() -> None:
    flown = Flown(
        HOME,
        item(TAKEOFF, up=5.0),
        item(Command.NAV_LOITER_TURNS, 0.0, 0.0, 5.0, (2.0, 0.0, 10.0, 0.0)),
        rules=ARDUPILOT,
    )
    flown.fly(2)
    leg = flown.legs[-1]
    assert (leg.flight, leg.radius) == (Flight.CIRCLE, 10.0)
    turns = 0.0
    while flown.mission.current == 2 and not flown.mission.complete:
        flown.position = leg.place + 10.0 * np.array((math.cos(turns), math.sin(turns), 0.0))
        flown.step()
        turns += 0.1
    assert turns == pytest.approx(4.0 * math.pi, abs=0.3)


def test_a_place_of_zeros_is_here() -> None:
    here = Item(WAYPOINT, 6, (0.0, 0.0, 0.0, math.nan), 0, 0, 8.0)
    flown = Flown(item(TAKEOFF, 0.0, 0.0, 5.0), here)
    flown.fly()
    assert flown.legs[-1].place == pytest.approx((0.0, 0.0, -8.0))


def test_ids_tell_plans_apart_and_none_is_zero() -> None:
    one, other = Plan((item(WAYPOINT, 1.0),)), Plan((item(WAYPOINT, 2.0),))
    assert Plan().opaque_id == 0
    assert 0 not in (one.opaque_id, other.opaque_id)
    assert one.opaque_id != other.opaque_id
    assert one.opaque_id == Plan((item(WAYPOINT, 1.0),)).opaque_id


@pytest.mark.parametrize("rules", [PX4, ARDUPILOT])
def test_a_mission_that_is_cleared_while_it_is_flown_ends_at_its_first_item(rules: MissionRules) -> None:
    flown = Flown(HOME, item(TAKEOFF, up=5.0), item(WAYPOINT, 10.0, 0.0, 5.0), rules=rules)
    flown.step()
    flown.mission.load(Plan(), 0)
    flown.step()
    assert (flown.mission.state, flown.mission.current) == (MissionState.NO_MISSION, rules.first)
