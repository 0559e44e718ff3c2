"""Waypoint files, `QGC WPL 110`: https://mavlink.io/en/file_formats/#mission_plain_text_file.

A line for each item, in twelve columns: sequence number, current, frame, command, parameters 1 to 4,
latitude, longitude, altitude, autocontinue. Tabs separate them; spaces are read too. Item 0 of version 110 is
home, as ArduPilot has it, if it is a waypoint above sea level; version 120 has none.
"""

import math
from collections.abc import Iterator
from dataclasses import replace

from companion.errors import InputError
from companion.geodesy import Place
from companion.link.dialect import mavlink
from companion.mission.items import Frame, MissionItem, Plan, frame_from_number, naming

_COLUMNS = 12
_HEADER = "QGC WPL 110"
_HEADERS = (_HEADER, "QGC WPL 120")
_NO_HOME = MissionItem(mavlink.MAV_CMD_NAV_WAYPOINT, Frame.GLOBAL)


def parse_waypoints(text: str) -> Plan:
    """The plan in a waypoint file's text.

    Raises:
        InputError: another format or version, or a value is wrong; names the line.
    """
    lines = [(number, line.split()) for number, line in enumerate(text.splitlines(), 1) if line.strip()]
    header = " ".join(lines[0][1]) if lines else ""
    if header not in _HEADERS:
        raise InputError(f"line 1: expected {_HEADER!r}, not {header[:40]!r}")
    items = list(_items(lines[1:]))
    home = None
    if items and header == _HEADER and _is_home(items[0]):
        place = items.pop(0)
        home = None if place.coordinates is None else Place(*place.coordinates, place.z or 0.0)
        items = [item.jumping(-1) for item in items]
    return Plan(mission=tuple(items), home=home, firmware=mavlink.MAV_AUTOPILOT_ARDUPILOTMEGA)


def waypoints_text(plan: Plan) -> str:
    """The mission of `plan` as a waypoint file, its item 0 home; a home that is not known is at 0, 0.

    Raises:
        InputError: the plan has a fence or rally points, which such a file cannot hold.
    """
    if plan.fence or plan.rally:
        raise InputError("a waypoint file holds no fence and no rally points: write a .plan instead")
    home = _NO_HOME
    if plan.home is not None:
        home = replace(home, x=plan.home.latitude_deg, y=plan.home.longitude_deg, z=plan.home.altitude_m)
    items = (home, *(item.jumping(1) for item in plan.mission))
    return "\n".join([_HEADER, *(_row(number, item) for number, item in enumerate(items))]) + "\n"


def _items(lines: list[tuple[int, list[str]]]) -> Iterator[MissionItem]:
    for expected, (line, fields) in enumerate(lines):
        with naming(f"line {line}"):
            if len(fields) != _COLUMNS:
                raise InputError(f"{len(fields)} columns where {_COLUMNS} were expected")
            sequence = _whole(fields[0], "sequence number")
            if sequence != expected:
                raise InputError(f"sequence number {sequence} where {expected} was expected")
            p1, p2, p3, p4, x, y, z = (_number(field) for field in fields[4:11])
            yield MissionItem(
                command=_whole(fields[3], "command"),
                frame=frame_from_number(_whole(fields[2], "frame")),
                params=(p1, p2, p3, p4),
                x=x,
                y=y,
                z=z,
                autocontinue=_whole(fields[11], "autocontinue") != 0,
            )


def _is_home(item: MissionItem) -> bool:
    return item.command == mavlink.MAV_CMD_NAV_WAYPOINT and item.frame is Frame.GLOBAL


def _row(number: int, item: MissionItem) -> str:
    numbers = (*item.params, item.x, item.y, item.z)
    written = ("nan" if value is None else repr(float(value)) for value in numbers)
    start = (number, int(number == 0), int(item.frame), item.command)
    return "\t".join([*map(str, start), *written, str(int(item.autocontinue))])


def _whole(field: str, what: str) -> int:
    value = _number(field)
    if value is None or value != int(value):
        raise InputError(f"{what} {field[:40]!r} is not a whole number")
    return int(value)


def _number(field: str) -> float | None:
    """The number in a field; None where it is `nan`, which leaves it to the autopilot."""
    try:
        value = float(field)
    except ValueError:
        raise InputError(f"{field[:40]!r} is not a number") from None
    if math.isinf(value):
        raise InputError(f"{field[:40]!r} is not a finite number")
    return None if math.isnan(value) else value
