"""The mission protocol over a mavutil link, as scripts with pymavlink have it: the library brings none."""

from collections.abc import Sequence
from typing import Any

from mavutil_link import MavutilLink
from pymavlink.dialects.v20 import common as mavlink

_RETRY_S = 0.25
_RETRIES = 40


def waypoint(link: MavutilLink, place: Sequence[float], command: int, kind: int, param1: float = 0.0) -> Any:
    """A MISSION_ITEM_INT at a place (degrees, m above home); its number is given when it is sent."""
    latitude_deg, longitude_deg, height_m = place
    return mavlink.MAVLink_mission_item_int_message(
        link.connection.target_system,
        mavlink.MAV_COMP_ID_AUTOPILOT1,
        0,
        mavlink.MAV_FRAME_GLOBAL_RELATIVE_ALT_INT,
        command,
        current=0,
        autocontinue=1,
        param1=param1,
        param2=0.0,
        param3=0.0,
        param4=float("nan") if command == mavlink.MAV_CMD_NAV_WAYPOINT else 0.0,
        x=round(latitude_deg * 1e7),
        y=round(longitude_deg * 1e7),
        z=height_m,
        mission_type=kind,
    )


def place_of(item: Any) -> tuple[float, float, float]:
    return item.x * 1e-7, item.y * 1e-7, item.z


def upload(link: MavutilLink, items: Sequence[Any], kind: int) -> None:
    """Send items; what is lost on the way is sent again."""
    for seq, item in enumerate(items):
        item.seq, item.current = seq, int(seq == 0)
    link.forget_answers()
    mav, target = link.connection.mav, (link.connection.target_system, mavlink.MAV_COMP_ID_AUTOPILOT1)
    requested, retries = False, 0
    mav.mission_count_send(*target, len(items), kind)
    while retries < _RETRIES:
        message = link.answer("MISSION_REQUEST_INT", "MISSION_REQUEST", "MISSION_ACK", timeout_s=_RETRY_S)
        if message is None:
            retries += 1
            if not requested:  # once it asks, asking again is the vehicle's part
                mav.mission_count_send(*target, len(items), kind)
        elif message.mission_type != kind:
            continue
        elif message.get_type() == "MISSION_ACK":
            if message.type != mavlink.MAV_MISSION_ACCEPTED:
                raise RuntimeError(f"refused: {mavlink.enums['MAV_MISSION_RESULT'][message.type].name}")
            return
        else:
            requested, retries = True, 0
            mav.send(items[message.seq])
    raise TimeoutError(f"no answer to the upload of {len(items)} items")


def download(link: MavutilLink, kind: int) -> list[Any]:
    link.forget_answers()
    mav, target = link.connection.mav, (link.connection.target_system, mavlink.MAV_COMP_ID_AUTOPILOT1)

    def ask(seq: int | None) -> Any:
        for _ in range(_RETRIES):
            if seq is None:
                mav.mission_request_list_send(*target, kind)
            else:
                mav.mission_request_int_send(*target, seq, kind)
            while message := link.answer("MISSION_COUNT", "MISSION_ITEM_INT", timeout_s=_RETRY_S):
                if message.mission_type == kind and getattr(message, "seq", None) == seq:
                    return message
        raise TimeoutError("no answer to the download of " + ("a count" if seq is None else f"item {seq}"))

    items = [ask(seq) for seq in range(ask(None).count)]
    mav.mission_ack_send(*target, mavlink.MAV_MISSION_ACCEPTED, kind)
    return items


def clear(link: MavutilLink, kind: int) -> None:
    link.forget_answers()
    link.connection.mav.mission_clear_all_send(
        link.connection.target_system, mavlink.MAV_COMP_ID_AUTOPILOT1, kind
    )
    message = link.answer("MISSION_ACK")
    if message is None or message.type != mavlink.MAV_MISSION_ACCEPTED:
        raise RuntimeError(f"not cleared: {message}")
