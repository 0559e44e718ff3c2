import math
from collections.abc import Callable, Sequence
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from mavlink_fakes import (
    ARDUCOPTER,
    BEBOP2,
    PEER_COMPONENT,
    PEER_SYSTEM,
    answers,
    empty_plans,
    encode,
    fake_vehicle,
    parse,
)
from plan_items import HOME, command, item
from pymavlink.dialects.v20 import common as mavlink

from sitl.conditions import LinkConditions
from sitl.firmware.interface import Mode
from sitl.mavlink import GROUND_STATION, OFFBOARD, MavlinkVehicle
from sitl.plan.items import Command, Item, PlanKind
from sitl.vehicle import Vehicle

MISSION = tuple(item(Command.NAV_WAYPOINT, 10.0 * n, 5.0, 20.0) for n in range(5))
SQUARE = tuple(
    item(Command.FENCE_INCLUSION_VERTEX, north, east, params=(4.0, 0.0, 0.0, 0.0))
    for north, east in ((-50.0, -50.0), (-50.0, 50.0), (50.0, 50.0), (50.0, -50.0))
)
PLANS = {
    PlanKind.MISSION: MISSION,
    PlanKind.FENCE: SQUARE,
    PlanKind.RALLY: (item(Command.RALLY_POINT, 20.0, 20.0, 10.0),),
}


def px4() -> MavlinkVehicle:
    return fake_vehicle()[0]


def ardupilot() -> MavlinkVehicle:
    vehicle, firmware = fake_vehicle(vehicle=ARDUCOPTER)
    firmware.plans = empty_plans(first=1)
    return vehicle


def on_board(vehicle: MavlinkVehicle, kind: PlanKind = PlanKind.MISSION) -> tuple[Item, ...]:
    return vehicle.simulation.firmware.plans[kind].items


def count(number: int, kind: int = 0) -> Any:
    return mavlink.MAVLink_mission_count_message(1, 1, number, kind)


def item_int(number: int, each: Item, kind: int = 0, current: int = 0) -> Any:
    head = (1, 1, number, each.frame, each.command, current, int(each.autocontinue))
    return mavlink.MAVLink_mission_item_int_message(*head, *each.params, each.x, each.y, each.z, kind)


def upload(vehicle: MavlinkVehicle, items: Sequence[Item], kind: PlanKind = PlanKind.MISSION) -> Any:
    """The answer that ends an upload in which nothing is lost."""
    (answer,) = answers(vehicle, count(len(items), kind))
    while answer.get_type() != "MISSION_ACK":
        assert answer.get_type() in ("MISSION_REQUEST_INT", "MISSION_REQUEST")
        *_, answer = answers(vehicle, item_int(answer.seq, items[answer.seq], kind))
    return answer


def download(vehicle: MavlinkVehicle, kind: PlanKind = PlanKind.MISSION) -> list[Any]:
    (listed,) = answers(vehicle, mavlink.MAVLink_mission_request_list_message(1, 1, kind))
    requests = (mavlink.MAVLink_mission_request_int_message(1, 1, n, kind) for n in range(listed.count))
    return [answers(vehicle, request)[0] for request in requests]


def same(received: Any, sent: Item) -> bool:
    params = (received.param1, received.param2, received.param3)
    place = (received.x, received.y, received.z)
    return (received.command, params, place) == (sent.command, sent.params[:3], (sent.x, sent.y, sent.z))


@pytest.mark.parametrize("vehicle", [px4, ardupilot])
@pytest.mark.parametrize("kind", PlanKind)
def test_what_goes_up_comes_down(vehicle: Callable[[], MavlinkVehicle], kind: PlanKind) -> None:
    flying = vehicle()
    items = (HOME, *PLANS[kind]) if vehicle is ardupilot and kind is PlanKind.MISSION else PLANS[kind]
    answer = upload(flying, items, kind)
    assert (answer.type, answer.mission_type) == (mavlink.MAV_MISSION_ACCEPTED, kind)
    assert (answer.target_system, answer.target_component) == (PEER_SYSTEM, PEER_COMPONENT)
    received = download(flying, kind)
    assert [message.seq for message in received] == list(range(len(items)))
    mine = 1 if items[0] is HOME else 0
    assert all(map(same, received[mine:], items[mine:]))


def test_px4_gives_frames_back_in_whole_numbers_and_ardupilot_without() -> None:
    for vehicle, frame in ((px4(), 6), (ardupilot(), 3)):
        upload(vehicle, MISSION)
        assert download(vehicle)[1].frame == frame


def test_each_autopilot_asks_in_its_own_way() -> None:
    (request,) = answers(px4(), count(2))
    assert (request.get_type(), request.seq) == ("MISSION_REQUEST_INT", 0)
    (request,) = answers(ardupilot(), count(2))
    assert (request.get_type(), request.seq) == ("MISSION_REQUEST", 0)


def test_px4_keeps_its_mission_until_the_last_item_has_come() -> None:
    vehicle = px4()
    upload(vehicle, MISSION)
    former = on_board(vehicle)
    answers(vehicle, count(2), item_int(0, item(Command.NAV_LAND)))
    assert on_board(vehicle) == former
    answers(vehicle, item_int(1, item(Command.NAV_LAND)))
    assert len(on_board(vehicle)) == 2


def test_ardupilot_writes_as_it_goes() -> None:
    vehicle = ardupilot()
    upload(vehicle, (HOME, *MISSION))
    answers(vehicle, count(3), item_int(0, HOME), item_int(1, item(Command.NAV_LAND)))
    assert [each.command for each in on_board(vehicle)] == [16, 21, 16]


def test_home_is_ardupilots_first_item_whatever_was_sent() -> None:
    vehicle = ardupilot()
    upload(vehicle, (item(9999, 40.0, 40.0), *MISSION))
    home = download(vehicle)[0]
    assert (home.command, home.frame, home.z) == (16, 0, pytest.approx(488.0))
    assert same(home, HOME) or home.x == HOME.x


def test_home_is_all_that_an_empty_mission_of_ardupilot_has() -> None:
    assert [each.command for each in download(ardupilot())] == [Command.NAV_WAYPOINT]
    assert download(px4()) == []


@pytest.mark.parametrize("vehicle", [px4, ardupilot])
def test_an_upload_of_nothing_clears(vehicle: Callable[[], MavlinkVehicle]) -> None:
    flying = vehicle()
    upload(flying, MISSION)
    assert upload(flying, ()).type == mavlink.MAV_MISSION_ACCEPTED
    assert on_board(flying) == ()


@pytest.mark.parametrize("kind", [0, 1, 2, 255])
def test_clearing_forgets_what_it_names(kind: int) -> None:
    vehicle = px4()
    for each, items in PLANS.items():
        upload(vehicle, items, each)
    (answer,) = answers(vehicle, mavlink.MAVLink_mission_clear_all_message(1, 1, kind))
    assert answer.type == mavlink.MAV_MISSION_ACCEPTED
    assert [each for each in PlanKind if not on_board(vehicle, each)] == [
        each for each in PlanKind if kind in (each, 255)
    ]


NAN = math.nan
FAR_NORTH = Item(16, 6, (0.0, 0.0, 0.0, NAN), 910_000_000, 0, 10.0)
FAR_EAST = Item(16, 6, (0.0, 0.0, 0.0, NAN), 0, 1_810_000_000, 10.0)
NO_ALTITUDE = Item(16, 6, (0.0, 0.0, 0.0, NAN), 473977420, 85455940, NAN)


@pytest.mark.parametrize(
    ("vehicle", "kind", "bad", "result"),
    [
        (px4, 0, item(9999), mavlink.MAV_MISSION_UNSUPPORTED),
        (px4, 0, command(9999), mavlink.MAV_MISSION_UNSUPPORTED),
        (px4, 0, item(Command.NAV_LOITER_TURNS), mavlink.MAV_MISSION_UNSUPPORTED),
        (px4, 0, item(Command.NAV_WAYPOINT, frame=1), mavlink.MAV_MISSION_UNSUPPORTED_FRAME),
        (px4, 0, item(Command.FENCE_INCLUSION_CIRCLE), mavlink.MAV_MISSION_ERROR),
        (px4, 0, item(Command.DO_SET_ROI, params=(2.0, 0.0, 0.0, 0.0)), mavlink.MAV_MISSION_INVALID_PARAM1),
        (px4, 0, FAR_NORTH, mavlink.MAV_MISSION_INVALID_PARAM5_X),
        (px4, 0, FAR_EAST, mavlink.MAV_MISSION_INVALID_PARAM6_Y),
        (px4, 0, NO_ALTITUDE, mavlink.MAV_MISSION_INVALID_PARAM7),
        (
            px4,
            1,
            item(Command.FENCE_INCLUSION_VERTEX, params=(2.0, 0.0, 0.0, 0.0)),
            mavlink.MAV_MISSION_ERROR,
        ),
        (px4, 1, item(Command.NAV_WAYPOINT), mavlink.MAV_MISSION_UNSUPPORTED),
        (ardupilot, 0, item(9999), mavlink.MAV_MISSION_UNSUPPORTED),
        (ardupilot, 0, item(Command.NAV_WAYPOINT, frame=1), mavlink.MAV_MISSION_UNSUPPORTED_FRAME),
        (ardupilot, 0, item(Command.NAV_WAYPOINT, params=(NAN, 0, 0, 0)), mavlink.MAV_MISSION_INVALID_PARAM1),
        (ardupilot, 0, FAR_NORTH, mavlink.MAV_MISSION_INVALID_PARAM5_X),
        (ardupilot, 0, NO_ALTITUDE, mavlink.MAV_MISSION_INVALID_PARAM7),
        (ardupilot, 1, item(Command.NAV_WAYPOINT), mavlink.MAV_MISSION_UNSUPPORTED),
        (ardupilot, 1, item(Command.FENCE_INCLUSION_CIRCLE), mavlink.MAV_MISSION_INVALID_PARAM1),
    ],
)
def test_a_bad_item_is_refused_and_ends_the_upload(
    vehicle: Callable[[], MavlinkVehicle], kind: int, bad: Item, result: int
) -> None:
    flying = vehicle()
    good = PLANS[PlanKind(kind)][0]
    *_, refused = answers(flying, count(3, kind), item_int(0, good, kind), item_int(1, bad, kind))
    assert (refused.get_type(), refused.type, refused.mission_type) == ("MISSION_ACK", result, kind)
    *_, late = answers(flying, item_int(1, good, kind))
    assert late.type == mavlink.MAV_MISSION_ERROR
    assert upload(flying, PLANS[PlanKind(kind)], PlanKind(kind)).type == mavlink.MAV_MISSION_ACCEPTED


@pytest.mark.parametrize("vehicle", [px4, ardupilot])
def test_too_many_items_are_refused_at_once(vehicle: Callable[[], MavlinkVehicle]) -> None:
    flying = vehicle()
    upload(flying, MISSION)
    text, answer = answers(flying, count(10_000))
    assert "items are supported" in text.text
    assert answer.type == mavlink.MAV_MISSION_NO_SPACE
    assert len(on_board(flying)) == len(MISSION)


def test_an_unknown_kind_of_plan_is_unsupported() -> None:
    for message in (count(2, 7), mavlink.MAVLink_mission_request_list_message(1, 1, 7)):
        (answer,) = answers(px4(), message)
        assert (answer.type, answer.mission_type) == (mavlink.MAV_MISSION_UNSUPPORTED, 7)


@pytest.mark.parametrize(
    ("vehicle", "busy"), [(px4, mavlink.MAV_MISSION_ERROR), (ardupilot, mavlink.MAV_MISSION_DENIED)]
)
def test_a_second_peer_has_to_wait(vehicle: Callable[[], MavlinkVehicle], busy: int) -> None:
    flying = vehicle()
    answers(flying, count(3), item_int(0, MISSION[0]))
    for message in (count(2), item_int(1, MISSION[1]), mavlink.MAVLink_mission_request_list_message(1, 1, 0)):
        flying.receive(encode(message, system=99))
        (answer,) = parse(flying.advance(flying.simulation.time_s + 0.01))
        assert (answer.type, answer.target_system) == (busy, 99)
    *_, answer = answers(flying, item_int(1, MISSION[1]), item_int(2, MISSION[2]))
    assert answer.type == mavlink.MAV_MISSION_ACCEPTED


def test_the_same_peer_may_begin_again() -> None:
    vehicle = px4()
    answers(vehicle, count(3), item_int(0, MISSION[0]))
    assert upload(vehicle, SQUARE, PlanKind.FENCE).type == mavlink.MAV_MISSION_ACCEPTED
    assert on_board(vehicle) == ()


def test_a_cancelled_upload_changes_nothing() -> None:
    vehicle = px4()
    cancel = mavlink.MAVLink_mission_ack_message(1, 1, mavlink.MAV_MISSION_OPERATION_CANCELLED, 0)
    answers(vehicle, count(3), item_int(0, MISSION[0]), cancel)
    assert vehicle.advance(vehicle.simulation.time_s + 1.0) == []
    assert upload(vehicle, MISSION).type == mavlink.MAV_MISSION_ACCEPTED


def test_px4_asks_again_four_times_a_second_and_gives_up_after_five_seconds() -> None:
    vehicle = px4()
    answers(vehicle, count(3), item_int(0, MISSION[0]))
    silence = parse(vehicle.advance(vehicle.simulation.time_s + 5.5))
    requests = [message for message in silence if message.get_type() == "MISSION_REQUEST_INT"]
    assert {message.seq for message in requests} == {1}
    assert 18 <= len(requests) <= 20
    text, ack = silence[-2:]
    assert text.text == "Operation timeout"
    assert ack.type == mavlink.MAV_MISSION_OPERATION_CANCELLED


def test_an_item_that_comes_twice_or_early_is_ignored_by_px4() -> None:
    vehicle = px4()
    (_, request, *rest) = answers(
        vehicle, count(3), item_int(0, MISSION[0]), item_int(0, MISSION[0]), item_int(2, MISSION[2])
    )
    assert (request.seq, rest) == (1, [])


def test_ardupilot_refuses_an_item_that_comes_early() -> None:
    *_, answer = answers(ardupilot(), count(3), item_int(2, MISSION[2]))
    assert answer.type == mavlink.MAV_MISSION_INVALID_SEQUENCE


def test_the_last_item_again_is_acknowledged_again() -> None:
    vehicle = px4()
    upload(vehicle, MISSION)
    (answer,) = answers(vehicle, item_int(4, MISSION[4]))
    assert answer.type == mavlink.MAV_MISSION_ACCEPTED


def test_part_of_ardupilots_mission_can_be_replaced() -> None:
    vehicle = ardupilot()
    upload(vehicle, (HOME, *MISSION))
    land = item(Command.NAV_LAND)
    part = mavlink.MAVLink_mission_write_partial_list_message(1, 1, 2, 3)
    *_, answer = answers(vehicle, part, item_int(2, land), item_int(3, land))
    assert answer.type == mavlink.MAV_MISSION_ACCEPTED
    assert [each.command for each in on_board(vehicle)] == [16, 16, 21, 21, 16, 16]
    beyond = mavlink.MAVLink_mission_write_partial_list_message(1, 1, 2, 30)
    assert answers(vehicle, beyond)[-1].type == mavlink.MAV_MISSION_ERROR


def test_items_in_degrees_are_taken_and_given() -> None:
    vehicle = px4()
    each = MISSION[1]
    answers(vehicle, count(1))
    message = mavlink.MAVLink_mission_item_message(
        1, 1, 0, 3, 16, 1, 1, 0.0, 0.0, 0.0, NAN, each.x * 1e-7, each.y * 1e-7, 20.0, 0
    )
    (answer,) = answers(vehicle, message)
    assert answer.type == mavlink.MAV_MISSION_ACCEPTED
    (given,) = answers(vehicle, mavlink.MAVLink_mission_request_message(1, 1, 0, 0))
    assert given.get_type() == "MISSION_ITEM"
    assert given.x == pytest.approx(each.x * 1e-7, abs=1e-5)


def test_an_item_that_there_is_not_is_an_error() -> None:
    (answer,) = answers(px4(), mavlink.MAVLink_mission_request_int_message(1, 1, 0, 0))
    assert answer.type == mavlink.MAV_MISSION_ERROR


def payload(frame: bytes) -> bytes:
    """Without the zeros at its end, which MAVLink 2 leaves out."""
    return frame[10 : 10 + frame[1]]


def test_px4_tells_the_ids_of_its_plans() -> None:
    vehicle = px4()
    upload(vehicle, MISSION[:4])
    vehicle.receive(encode(item_int(3, MISSION[3])))
    ack = vehicle.advance(vehicle.simulation.time_s)[0].data
    opaque_id = vehicle.simulation.firmware.plans[PlanKind.MISSION].opaque_id
    assert int.from_bytes(payload(ack)[4:8], "little") == opaque_id
    vehicle.receive(encode(mavlink.MAVLink_mission_request_list_message(1, 1, 0)))
    listed = vehicle.advance(vehicle.simulation.time_s)[0].data
    assert int.from_bytes(payload(listed)[5:9], "little") == opaque_id
    vehicle.receive(encode(mavlink.MAVLink_mission_set_current_message(1, 1, 2)))
    current = vehicle.advance(vehicle.simulation.time_s)[0].data
    assert payload(current)[:6] == bytes((2, 0, 4, 0, 2, 2))
    assert int.from_bytes(payload(current)[6:10], "little") == opaque_id


def test_the_current_item_is_set_or_refused() -> None:
    vehicle = px4()
    upload(vehicle, MISSION)
    current, *_ = answers(vehicle, mavlink.MAVLink_mission_set_current_message(1, 1, 3))
    assert (current.get_type(), current.seq, current.total) == ("MISSION_CURRENT", 3, 5)
    (text,) = answers(vehicle, mavlink.MAVLink_mission_set_current_message(1, 1, 9))
    assert "Not in list" in text.text
    assert vehicle.simulation.firmware.plans.mission.current == 3


def test_ardupilot_does_not_count_home() -> None:
    vehicle, firmware = fake_vehicle(vehicle=ARDUCOPTER)
    firmware.plans = empty_plans(first=1)
    firmware.mode = Mode.MISSION
    upload(vehicle, (HOME, *MISSION))
    (current,) = answers(vehicle, mavlink.MAVLink_mission_set_current_message(1, 1, 2))
    assert (current.seq, current.total, current.mission_mode) == (2, 5, 1)


@pytest.mark.parametrize(("vehicle", "times"), [(BEBOP2, 11), (ARDUCOPTER, 1)], ids=["px4", "ardupilot"])
def test_px4_repeats_what_was_reached_last(vehicle: Vehicle, times: int) -> None:
    flying, firmware = fake_vehicle(vehicle=vehicle)
    flying.advance(0.05)
    firmware.plans.mission.reached.extend((0, 1))
    told = [
        message.seq for message in parse(flying.advance(20.0)) if message.get_type() == "MISSION_ITEM_REACHED"
    ]
    assert told == [0] + [1] * times


def test_px4_tells_at_once_which_item_is_current() -> None:
    flying, firmware = fake_vehicle()
    upload(flying, MISSION)
    flying.advance(flying.simulation.time_s + 0.5)
    firmware.plans.mission.go_to(1)
    news = parse(flying.advance(flying.simulation.time_s + 0.02))
    assert [message.seq for message in news if message.get_type() == "MISSION_CURRENT"] == [1]


def test_what_is_reached_is_told_on_every_link() -> None:
    vehicle, firmware = fake_vehicle(links=(OFFBOARD, GROUND_STATION))
    firmware.plans.mission.reached.extend((0, 1))
    told = [
        message for message in parse(vehicle.advance(0.05)) if message.get_type() == "MISSION_ITEM_REACHED"
    ]
    assert [message.seq for message in told] == [0, 1, 0, 1]


class Client:
    """The least that a peer does: answers requests, and repeats its last message when nothing comes."""

    def __init__(self, vehicle: MavlinkVehicle, items: Sequence[Item]) -> None:
        self.vehicle = vehicle
        self.items = items
        self.result: int | None = None
        self.last: Any = count(len(items))

    def run(self, patience_s: float) -> int | None:
        vehicle, ticks_silent = self.vehicle, 0
        vehicle.receive(encode(self.last))
        end_s = vehicle.simulation.time_s + patience_s
        waiting: list[Any] = []
        while vehicle.simulation.time_s < end_s and self.result is None:
            now_s = vehicle.simulation.time_s + 0.01
            waiting = sorted(waiting + vehicle.advance(now_s), key=lambda each: each.time_s)
            arrived = [each for each in waiting if each.time_s <= now_s]
            waiting = [each for each in waiting if each.time_s > now_s]
            heard = sum(map(self.hear, parse(arrived)))
            ticks_silent = 0 if heard else ticks_silent + 1
            if ticks_silent == 150:
                ticks_silent = 0
                vehicle.receive(encode(self.last))
        return self.result

    def hear(self, message: Any) -> bool:
        if message.get_type() == "MISSION_ACK":
            self.result = int(message.type)
        elif message.get_type() in ("MISSION_REQUEST", "MISSION_REQUEST_INT"):
            self.last = item_int(message.seq, self.items[message.seq])
            self.vehicle.receive(encode(self.last))
        else:
            return False
        return True


@settings(max_examples=5, deadline=None)
@given(st.integers(0, 10_000), st.sampled_from((px4, ardupilot)))
def test_a_bad_link_does_not_spoil_an_upload(seed: int, kind: Callable[[], MavlinkVehicle]) -> None:
    link = LinkConditions(
        telemetry_latency_s=0.02,
        telemetry_jitter_s=0.05,
        telemetry_loss_fraction=0.05,
        telemetry_duplicate_fraction=0.02,
        telemetry_overtaken_fraction=0.02,
        setpoint_latency_s=0.02,
        setpoint_jitter_s=0.05,
        setpoint_loss_fraction=0.05,
        setpoint_duplicate_fraction=0.02,
        setpoint_overtaken_fraction=0.02,
    )
    vehicle, firmware = fake_vehicle(link, seed=seed, vehicle=BEBOP2 if kind is px4 else ARDUCOPTER)
    if kind is ardupilot:
        firmware.plans = empty_plans(first=1)
    items = [item(Command.NAV_WAYPOINT, float(n), 5.0, 20.0) for n in range(60)]
    assert Client(vehicle, items).run(patience_s=120.0) == mavlink.MAV_MISSION_ACCEPTED
    assert [each.x for each in on_board(vehicle)] == [each.x for each in items]
