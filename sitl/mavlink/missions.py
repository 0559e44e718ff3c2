"""The mission protocol: plans up and down, for missions, fences and rally points.

https://mavlink.io/en/services/mission.html, as PX4's `mavlink_mission.cpp` and ArduPilot's
`MissionItemProtocol.cpp` keep it; where they differ, `MissionWire` has it. With links that duplicate frames
both are less patient than is useful: here ArduPilot, too, ignores an item that comes twice and acknowledges
the last one again, and PX4, too, begins anew when the peer does.
"""

from typing import Any

from pymavlink.dialects.v20 import common as mavlink

from sitl.firmware.interface import Severity
from sitl.geodesy import geodetic_from_ned
from sitl.mavlink.frames import Message
from sitl.mavlink.mission_upload import Peer, Upload
from sitl.mavlink.opaque_ids import MissionAck, MissionCount
from sitl.mavlink.session import Session
from sitl.plan.fence import FenceError, boundary
from sitl.plan.items import Command, Item, PlanKind
from sitl.plan.places import GLOBAL

_ALL_KINDS = 255


def _peer(message: Message) -> Peer:
    return message.get_srcSystem(), message.get_srcComponent()


def _kind(message: Any) -> PlanKind | None:
    known = message.mission_type in PlanKind.__members__.values()
    return PlanKind(message.mission_type) if known else None


def _acknowledge(session: Session, peer: Peer, kind: int, result: int, opaque_id: int = 0) -> None:
    wanted_id = opaque_id if session.flavour.missions.has_ids else 0
    session.send(MissionAck(*peer, result, kind, wanted_id))


def _is_busy(session: Session, message: Any) -> bool:
    """Whether an upload keeps another request from being served; says so."""
    if session.uploads.active is None:
        return False
    _acknowledge(session, _peer(message), message.mission_type, session.flavour.missions.busy)
    return True


# Uploads


def on_count(session: Session, message: mavlink.MAVLink_mission_count_message) -> None:
    """Begin an upload, or begin it again."""
    if not session.accepts(message.target_system, message.target_component):
        return
    wire, peer, kind = session.flavour.missions, _peer(message), _kind(message)
    active = session.uploads.active
    if active and active.peer != peer:
        _acknowledge(session, peer, message.mission_type, wire.busy)
    elif active and active.begins_with(message.mission_type, message.count, session.time_s):
        active.ask(session.time_s)
    elif kind is None:
        _acknowledge(session, peer, message.mission_type, mavlink.MAV_MISSION_UNSUPPORTED)
    elif message.count > wire.capacity[kind]:
        session.say(Severity.WARNING, f"Only {wire.capacity[kind]} items are supported")
        _acknowledge(session, peer, kind, mavlink.MAV_MISSION_NO_SPACE)
    else:
        former = [] if kind in wire.atomic else list(session.firmware.plans[kind].items[: message.count])
        _begin(session, Upload(wire, peer, kind, session.send, 0, message.count, former))


def on_write_partial_list(
    session: Session, message: mavlink.MAVLink_mission_write_partial_list_message
) -> None:
    """Replace some items of a plan."""
    if not session.accepts(message.target_system, message.target_component) or _is_busy(session, message):
        return
    peer, kind = _peer(message), _kind(message)
    first, last = message.start_index, message.end_index
    items = list(session.firmware.plans[kind].items) if kind is not None else []
    if kind is None or not 0 <= first <= last < len(items):
        session.say(Severity.WARNING, "Flight plan update rejected")
        _acknowledge(session, peer, message.mission_type, mavlink.MAV_MISSION_ERROR)
        return
    _begin(session, Upload(session.flavour.missions, peer, kind, session.send, first, last + 1, items))


def _begin(session: Session, upload: Upload) -> None:
    upload.heard_s = upload.began_s = session.time_s
    session.uploads.active = upload
    if upload.complete:
        _finish(session, upload)
        return
    if upload.kind not in upload.wire.atomic:
        _keep(session, upload)
    upload.ask(session.time_s)


def on_item(session: Session, message: mavlink.MAVLink_mission_item_message) -> None:
    """An item with its place in degrees, which fewer and fewer peers send."""
    scale = 1e7 if message.frame in GLOBAL else 1.0
    placed = all(abs(value) * scale < 2**31 for value in (message.x, message.y))
    x, y = (round(message.x * scale), round(message.y * scale)) if placed else (2**31 - 2, 0)
    _take(session, message, x, y)


def on_item_int(session: Session, message: mavlink.MAVLink_mission_item_int_message) -> None:
    """An item."""
    _take(session, message, message.x, message.y)


def _take(session: Session, message: Any, x: int, y: int) -> None:
    if not session.accepts(message.target_system, message.target_component):
        return
    peer, upload = _peer(message), session.uploads.active
    if upload is None:
        _answer_late_item(session, message)
        return
    if peer != upload.peer or message.mission_type != upload.kind:
        _acknowledge(session, peer, message.mission_type, upload.wire.busy)
        return
    if message.seq != upload.expected:
        if message.seq > upload.expected and upload.wire.refuses_out_of_turn:
            _acknowledge(session, peer, upload.kind, mavlink.MAV_MISSION_INVALID_SEQUENCE)
        return
    params = (message.param1, message.param2, message.param3, message.param4)
    item = Item(message.command, message.frame, params, x, y, message.z, bool(message.autocontinue))
    is_home = upload.wire.has_home and upload.kind is PlanKind.MISSION and message.seq == 0
    result = mavlink.MAV_MISSION_ACCEPTED if is_home else upload.wire.check(upload.kind, item)
    if result != mavlink.MAV_MISSION_ACCEPTED:
        session.say(Severity.CRITICAL, f"IGN MISSION_ITEM: Invalid item {message.seq}")
        _acknowledge(session, peer, upload.kind, result)
        session.uploads.active = None
        return
    upload.take(item, session.time_s)
    if message.current:
        upload.current = message.seq
    if upload.complete:
        _finish(session, upload)
        return
    if upload.kind not in upload.wire.atomic:
        _keep(session, upload)
    upload.ask(session.time_s)


def _answer_late_item(session: Session, message: Any) -> None:
    """The last item again: its acknowledgement was lost. Any other comes too late, or unasked."""
    last, peer = session.uploads.last, _peer(message)
    if last and last.peer == peer and (last.kind, last.end - 1) == (message.mission_type, message.seq):
        opaque_id = session.firmware.plans[last.kind].opaque_id
        _acknowledge(session, peer, last.kind, mavlink.MAV_MISSION_ACCEPTED, opaque_id)
    else:
        _acknowledge(session, peer, message.mission_type, mavlink.MAV_MISSION_ERROR)


def _keep(session: Session, upload: Upload) -> None:
    plans = session.firmware.plans
    current = upload.current if upload.kind in upload.wire.atomic else plans.mission.current
    plans.replace(upload.kind, tuple(upload.items), current)


def _finish(session: Session, upload: Upload) -> None:
    uploads = session.uploads
    uploads.active, uploads.last = None, upload
    try:
        if upload.kind is PlanKind.FENCE:
            boundary(tuple(upload.items))
    except FenceError as error:
        session.say(Severity.CRITICAL, str(error))
        _acknowledge(session, upload.peer, upload.kind, mavlink.MAV_MISSION_ERROR)
        return
    _keep(session, upload)
    opaque_id = session.firmware.plans[upload.kind].opaque_id
    _acknowledge(session, upload.peer, upload.kind, mavlink.MAV_MISSION_ACCEPTED, opaque_id)


def on_ack(session: Session, message: mavlink.MAVLink_mission_ack_message) -> None:
    """The peer ends the upload."""
    upload = session.uploads.active
    cancelled = message.type == mavlink.MAV_MISSION_OPERATION_CANCELLED
    if upload and cancelled and upload.peer == _peer(message) and upload.kind == message.mission_type:
        session.uploads.active = None


def keep_time(session: Session) -> None:
    """Ask again for an item that does not come, and give up in the end."""
    upload = session.uploads.active
    if upload is not None and upload.has_timed_out(session.time_s):
        session.uploads.active = None
        session.say(Severity.CRITICAL, "Operation timeout")
        upload.send(MissionAck(*upload.peer, mavlink.MAV_MISSION_OPERATION_CANCELLED, upload.kind, 0))


# Downloads, and the rest


def on_request_list(session: Session, message: mavlink.MAVLink_mission_request_list_message) -> None:
    """How many items there are."""
    if not session.accepts(message.target_system, message.target_component) or _is_busy(session, message):
        return
    kind = _kind(message)
    if kind is None:
        _acknowledge(session, _peer(message), message.mission_type, mavlink.MAV_MISSION_UNSUPPORTED)
        return
    plan = session.firmware.plans[kind]
    opaque_id = plan.opaque_id if session.flavour.missions.has_ids else 0
    count = max(len(plan), 1) if _begins_with_home(session, kind) else len(plan)
    session.send(MissionCount(*_peer(message), count, kind, opaque_id))


def on_request(session: Session, message: mavlink.MAVLink_mission_request_message) -> None:
    """One item, with its place in degrees."""
    item = _requested(session, message)
    if item is None:
        return
    scale = 1e-7 if item.frame in GLOBAL else 1.0
    current = _is_current(session, message)
    fields = (*item.params, item.x * scale, item.y * scale, item.z)
    head = (*_peer(message), message.seq, item.frame, item.command, current, item.autocontinue)
    session.send(mavlink.MAVLink_mission_item_message(*head, *fields, message.mission_type))


def on_request_int(session: Session, message: mavlink.MAVLink_mission_request_int_message) -> None:
    """One item."""
    item = _requested(session, message)
    if item is None:
        return
    frame = session.flavour.missions.frames.get(item.frame, item.frame)
    current = _is_current(session, message)
    head = (*_peer(message), message.seq, frame, item.command, current, item.autocontinue)
    fields = (*item.params, item.x, item.y, item.z)
    session.send(mavlink.MAVLink_mission_item_int_message(*head, *fields, message.mission_type))


def _requested(session: Session, message: Any) -> Item | None:
    if not session.accepts(message.target_system, message.target_component) or _is_busy(session, message):
        return None
    kind = _kind(message)
    items = session.firmware.plans[kind].items if kind is not None else ()
    number = int(message.seq)
    if number == 0 and _begins_with_home(session, kind):
        return _home_item(session)
    if number >= len(items):
        _acknowledge(session, _peer(message), message.mission_type, mavlink.MAV_MISSION_ERROR)
        return None
    return items[number]


def _begins_with_home(session: Session, kind: PlanKind | None) -> bool:
    """ArduPilot keeps home as item 0 of its mission, even of an empty one once home is known."""
    return kind is PlanKind.MISSION and session.flavour.missions.has_home


def _home_item(session: Session) -> Item:
    north, east, down = session.firmware.plans.home.tolist()
    home = geodetic_from_ned(north, east, down, session.flavour.earth_radius_m)
    x, y = round(home.latitude_deg * 1e7), round(home.longitude_deg * 1e7)
    return Item(Command.NAV_WAYPOINT, mavlink.MAV_FRAME_GLOBAL, x=x, y=y, z=home.altitude_m)


def _is_current(session: Session, message: Any) -> bool:
    current = session.firmware.plans.mission.current
    return (message.mission_type, message.seq) == (PlanKind.MISSION, current)


def on_clear_all(session: Session, message: mavlink.MAVLink_mission_clear_all_message) -> None:
    """Forget a plan, or all of them."""
    if not session.accepts(message.target_system, message.target_component) or _is_busy(session, message):
        return
    kind = _kind(message)
    if kind is None and message.mission_type != _ALL_KINDS:
        _acknowledge(session, _peer(message), message.mission_type, mavlink.MAV_MISSION_UNSUPPORTED)
        return
    for each in PlanKind if kind is None else (kind,):
        session.firmware.plans.replace(each, ())
    _acknowledge(session, _peer(message), message.mission_type, mavlink.MAV_MISSION_ACCEPTED)


def on_set_current(session: Session, message: mavlink.MAVLink_mission_set_current_message) -> None:
    """Continue the mission at another item; the answer is MISSION_CURRENT."""
    if not session.accepts(message.target_system, message.target_component):
        return
    if not set_current(session, message.seq):
        session.say(Severity.CRITICAL, "WPM: WP CURR CMD: Not in list")


def set_current(session: Session, number: int) -> bool:
    """Continue the mission at an item, if there is such a one."""
    mission = session.firmware.plans.mission
    if not 0 <= number < len(mission.plan):
        return False
    mission.go_to(number)
    session.send(session.flavour.writers[mavlink.MAVLINK_MSG_ID_MISSION_CURRENT](session.report()))
    return True
