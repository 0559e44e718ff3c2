import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st
from plans import plan_object, plans, simple, waypoint

from companion.errors import InputError
from companion.geodesy import Place
from companion.mission.files import LARGEST_FILE_BYTES, read_plan, write_plan
from companion.mission.items import Fence, Frame, MissionItem, Plan
from companion.mission.plan_file import parse_plan, plan_text
from companion.mission.waypoint_file import parse_waypoints, waypoints_text


def parse(content: dict[str, Any]) -> Plan:
    return parse_plan(json.dumps(content).encode())


@given(plans)
def test_a_plan_file_keeps_everything(plan: Plan) -> None:
    assert parse_plan(plan_text(plan).encode()) == plan


@given(plans)
def test_a_waypoint_file_keeps_mission_and_home(plan: Plan) -> None:
    plan = Plan(plan.mission, home=plan.home, firmware=3)
    assert parse_waypoints(waypoints_text(plan)) == plan


@given(st.binary(max_size=200) | st.text(max_size=100).map(str.encode))
def test_anything_else_is_refused(tmp_path_factory: pytest.TempPathFactory, content: bytes) -> None:
    file = tmp_path_factory.getbasetemp() / "any.plan"
    file.write_bytes(content)
    with pytest.raises(InputError, match=r"any\.plan: "):
        read_plan(file)


def test_a_survey_is_read_as_its_stored_items() -> None:
    survey = {
        "type": "ComplexItem",
        "complexItemType": "survey",
        "version": 5,
        "polygon": [[47.398, 8.546], [47.399, 8.546], [47.399, 8.547]],
        "TransectStyleComplexItem": {"version": 2, "Items": [simple(2), simple(3, 206, 2)]},
    }
    plan = parse(plan_object(simple(1, 22), survey, simple(4)))
    assert [item.command for item in plan.mission] == [22, 16, 206, 16]
    assert parse_plan(plan_text(plan).encode()) == plan


def test_altitudes_are_those_of_the_params() -> None:
    above_terrain = simple(
        1,
        frame=0,
        params=[0, 0, 0, None, 47.4, 8.5, 530.0],
        Altitude=30,
        AltitudeMode=3,
        AMSLAltAboveTerrain=530.0,
    )
    (item,) = parse(plan_object(above_terrain)).mission
    assert item.place(Place(47.0, 8.0, 488.0)) == Place(47.4, 8.5, 530.0)


def test_an_item_above_home_is_placed_above_it() -> None:
    home = Place(47.0, 8.0, 488.0)
    assert waypoint(47.4, 8.5, 10.0).place(home) == Place(47.4, 8.5, 498.0)
    assert MissionItem(21, Frame.ABOVE_HOME).place(home) is None


def test_a_jump_finds_its_target_by_id() -> None:
    jump = simple(7, 177, 2, params=[20, 2, 0, 0, 0, 0, 0])
    plan = parse(plan_object(simple(20), simple(1), jump))
    assert plan.mission[2].params[0] == 0.0
    with pytest.raises(InputError, match="doJumpId 99"):
        parse(plan_object(simple(1), simple(2, 177, 2, params=[99, 2, 0, 0, 0, 0, 0])))


def test_fence_and_rally_points_are_read() -> None:
    content = plan_object(simple(1))
    content["geoFence"]["circles"] = [
        {"version": 1, "inclusion": False, "circle": {"center": [47.4, 8.5], "radius": 20}}
    ]
    content["geoFence"]["breachReturn"] = [47.4, 8.5, 50]
    content["rallyPoints"]["points"] = [[47.41, 8.51, 40]]
    plan = parse(content)
    assert plan.fence.circles[0].radius_m == 20.0
    assert not plan.fence.circles[0].inclusion
    assert plan.fence.breach_return == Place(47.4, 8.5, 50.0)
    assert plan.rally == (Place(47.41, 8.51, 40.0),)


def test_what_is_written_has_the_keys_that_qgroundcontrol_demands() -> None:
    written = json.loads(plan_text(Plan((waypoint(), MissionItem(20)), home=Place(47.0, 8.0, 488.0))))
    assert {"fileType", "version", "groundStation", "mission", "geoFence", "rallyPoints"} == set(written)
    first, second = written["mission"]["items"]
    assert (first["doJumpId"], second["doJumpId"]) == (1, 2)
    assert (first["Altitude"], first["AltitudeMode"], first["AMSLAltAboveTerrain"]) == (10.0, 1, None)
    assert "Altitude" not in second
    assert written["mission"]["plannedHomePosition"] == [47.0, 8.0, 488.0]


WRONG_PLANS = [
    (lambda plan: plan.update(version=2), "version: Input should be 1"),
    (lambda plan: plan.update(fileType="Params"), "fileType"),
    (lambda plan: plan["mission"].update(version=1), r"mission\.version"),
    (lambda plan: plan["geoFence"].update(version=1), r"geoFence\.version"),
    (lambda plan: plan["rallyPoints"].update(version=3), r"rallyPoints\.version"),
    (lambda plan: plan.pop("mission"), "mission: Field required"),
    (lambda plan: plan["mission"]["items"].append({"type": "Nothing"}), r"mission\.items\.1"),
    (lambda plan: plan["mission"]["items"].append(simple(1)), r"mission\.items\.1\.doJumpId: 1 is taken"),
    (lambda plan: plan["mission"]["items"][0].update(command=7777), r"mission\.items\.0: command 7777"),
    (lambda plan: plan["mission"]["items"][0].update(frame=8), r"mission\.items\.0: frame 8"),
    (
        lambda plan: plan["mission"]["items"][0]["params"].__setitem__(4, 91),
        r"items\.0: latitude \(degrees\) 91 is out of range",
    ),
    (lambda plan: plan["mission"]["items"][0]["params"].__setitem__(5, 181), r"items\.0: longitude"),
    (lambda plan: plan["mission"]["items"][0]["params"].__setitem__(4, float("nan")), r"items\.0\.params\.4"),
    (lambda plan: plan["mission"]["items"][0]["params"].__setitem__(6, float("inf")), r"items\.0\.params\.6"),
    (lambda plan: plan["mission"]["items"][0]["params"].__setitem__(4, None), r"items\.0: .*must be given"),
    (lambda plan: plan["mission"]["items"][0]["params"].pop(), r"items\.0\.params"),
    (
        lambda plan: plan["mission"]["items"].append(
            {"type": "ComplexItem", "complexItemType": "StructureScan"}
        ),
        r"items\.1: the StructureScan has no",
    ),
    (lambda plan: plan["mission"].update(plannedHomePosition=[95, 8, 0]), "home: latitude"),
    (
        lambda plan: plan["geoFence"]["polygons"].append({"inclusion": True, "polygon": [[1, 2], [3, 4]]}),
        r"geoFence\.polygons\.0: .* at least 3 corners",
    ),
    (
        lambda plan: plan["geoFence"]["circles"].append(
            {"inclusion": True, "circle": {"center": [1, 2], "radius": -1}}
        ),
        r"geoFence\.circles\.0: the radius",
    ),
    (lambda plan: plan["rallyPoints"]["points"].append([91, 0, 0]), "rally point 0: latitude"),
    (
        lambda plan: plan["mission"].update(items=[simple(number) for number in range(10_000)]),
        "10000 items",
    ),
]


@pytest.mark.parametrize(("spoil", "message"), WRONG_PLANS)
def test_what_is_wrong_in_a_plan_is_named(spoil: Any, message: str) -> None:
    content = plan_object(simple(1))
    parse(content)
    spoil(content)
    with pytest.raises(InputError, match=message):
        parse(content)


def test_every_truncated_plan_is_refused() -> None:
    content = json.dumps(plan_object(simple(1), simple(2))).encode()
    for length in range(len(content)):
        with pytest.raises(InputError):
            parse_plan(content[:length])


def test_nesting_without_end_is_refused() -> None:
    with pytest.raises(InputError, match="recursion"):
        parse_plan(b'{"a":' + b"[" * 100_000)


WAYPOINTS = """QGC WPL 110
0\t1\t0\t16\t0\t0\t0\t0\t47.397742\t8.545594\t488\t1
1\t0\t3\t22\t0\t0\t0\tnan\t47.397742\t8.545594\t10\t1
2\t0\t3\t16\t0\t0\t0\t0\t47.398\t8.546\t10\t1
3\t0\t2\t177\t2\t3\t0\t0\t0\t0\t0\t1
"""


def test_item_0_of_a_waypoint_file_is_home() -> None:
    plan = parse_waypoints(WAYPOINTS)
    assert plan.home == Place(47.397742, 8.545594, 488.0)
    assert [item.name for item in plan.mission] == ["NAV_TAKEOFF", "NAV_WAYPOINT", "DO_JUMP"]
    assert plan.mission[0].params[3] is None
    assert plan.mission[2].params[:2] == (1.0, 3.0)


def test_columns_may_be_separated_by_spaces_and_lines_end_as_on_windows() -> None:
    spaced = WAYPOINTS.replace("\t", "  ").replace("\n", "\r\n")
    assert parse_waypoints(spaced) == parse_waypoints(WAYPOINTS)


def test_a_waypoint_file_without_home_keeps_its_first_item() -> None:
    plan = parse_waypoints("QGC WPL 110\n0 1 3 22 0 0 0 0 47.4 8.5 10 1\n")
    assert plan.home is None
    assert [item.command for item in plan.mission] == [22]


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("WPL 110", "WPL 100", "line 1: expected 'QGC WPL 110'"),
        ("2\t0\t3\t16", "1\t0\t3\t16", "line 4: sequence number 1 where 2"),
        ("47.398\t", "97.398\t", "line 4: latitude"),
        ("47.398\t", "nan\t", "line 4: NAV_WAYPOINT: latitude"),
        ("47.398\t", "inf\t", "line 4: 'inf'"),
        ("47.398\t", "north\t", "line 4: 'north'"),
        ("\t47.398", "", "line 4: 11 columns"),
        ("\t22\t", "\t9999\t", "line 3: command 9999"),
        ("\t22\t", "\t2.5\t", "line 3: command '2.5'"),
        ("177\t2", "177\t9", "item 2: it jumps"),
        ("3\t0\t2", "3\t0\t1", "line 5: frame 1"),
    ],
)
def test_what_is_wrong_in_a_waypoint_file_is_named(old: str, new: str, message: str) -> None:
    with pytest.raises(InputError, match=message):
        parse_waypoints(WAYPOINTS.replace(old, new))


def test_the_name_of_a_file_tells_its_format(tmp_path: Path) -> None:
    plan = Plan((waypoint(),), home=Place(47.0, 8.0, 488.0), firmware=3)
    for name in ("a.plan", "a.waypoints", "a.txt", "A.PLAN"):
        write_plan(plan, tmp_path / name)
        assert read_plan(tmp_path / name) == plan
    with pytest.raises(InputError, match="name it"):
        write_plan(plan, tmp_path / "a.kml")
    with pytest.raises(InputError, match="rally"):
        write_plan(replace(plan, rally=(Place(47.0, 8.0, 10.0),)), tmp_path / "a.txt")
    with pytest.raises(InputError, match="cannot be written"):
        write_plan(plan, tmp_path / "nowhere" / "a.plan")
    assert not Fence()


def test_a_file_that_is_missing_or_too_large_is_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="cannot be read"):
        read_plan(tmp_path / "none.plan")
    large = tmp_path / "large.plan"
    with large.open("wb") as file:
        file.truncate(LARGEST_FILE_BYTES + 1)
    with pytest.raises(InputError, match="larger than 20 MB"):
        read_plan(large)
