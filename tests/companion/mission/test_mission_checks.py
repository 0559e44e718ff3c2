import re
from dataclasses import replace

import pytest
from plans import waypoint

from companion.mission import Fence, FenceCircle, FencePolygon, Frame, Mission, MissionItem, Place, Plan
from companion.mission.checks import check_places, check_plan
from companion.mission.site import planned_site

HOME = Place(47.397742, 8.545594, 488.0)
NO_FENCE = Fence()
GOOD = Mission().takeoff(5).go(10, 0, 5).go(100, 0, 5).return_home().plan(HOME)


def faults_of_places(fence: Fence = NO_FENCE, max_distance_m: float = 500.0) -> tuple[str, ...]:
    return check_places(GOOD, planned_site(GOOD), fence, "vehicle", max_distance_m).faults


def test_a_plan_that_can_be_flown_has_no_faults() -> None:
    findings = check_plan(GOOD)
    assert (findings.faults, findings.remarks, faults_of_places()) == ((), (), ())


@pytest.mark.parametrize(
    ("item", "message"),
    [
        (MissionItem(22, Frame.ABOVE_HOME), "item 0: NAV_TAKEOFF needs a positive altitude"),
        (MissionItem(5001, Frame.GLOBAL, x=1.0, y=1.0), "item 0: .* belongs in a fence"),
        (MissionItem(17, Frame.ABOVE_HOME, x=1.0, y=1.0, z=None), "item 0: NAV_LOITER_UNLIM has no altitude"),
    ],
)
def test_items_that_mean_nothing_are_faults(item: MissionItem, message: str) -> None:
    (fault,) = check_plan(replace(GOOD, mission=(item, *GOOD.mission))).faults
    assert re.match(message, fault)


def test_an_empty_mission_is_a_fault() -> None:
    assert check_plan(Plan()).faults == ("there are no items",)


def test_what_may_not_be_meant_is_remarked() -> None:
    below, under_the_sea = waypoint(altitude_m=-5.0), replace(waypoint(), frame=Frame.GLOBAL, z=10.0)
    remarks = check_plan(Plan((below, under_the_sea), home=HOME)).remarks
    assert [remark.partition(":")[0] for remark in remarks] == [
        "it does not begin with a takeoff",
        "item 0",
        "item 1",
    ]


def test_a_place_that_is_too_far_is_a_fault() -> None:
    assert faults_of_places(max_distance_m=50.0) == (
        "item 2: NAV_WAYPOINT is 100 m from takeoff, more than 50 m",
    )


def test_a_place_beyond_the_fence_is_a_fault() -> None:
    square = FencePolygon(((47.3970, 8.545), (47.3970, 8.547), (47.3982, 8.547), (47.3982, 8.545)))
    circle = FenceCircle(HOME.latitude_deg, HOME.longitude_deg, 20.0)
    assert len(faults_of_places(Fence((square,)))) == 1
    assert faults_of_places(Fence((), (circle,))) == (
        "item 2: NAV_WAYPOINT is 80.0 m beyond the vehicle's fence",
    )
    assert faults_of_places(Fence((square,), (circle,))) == faults_of_places(Fence((square,)))
    assert len(faults_of_places(Fence((), (replace(circle, inclusion=False),)))) == 2
