"""Plans from files of either kind, and to them."""

from pathlib import Path

from companion.bounded_file import read_bounded
from companion.errors import InputError
from companion.mission.items import Plan, naming
from companion.mission.plan_file import parse_plan, plan_text
from companion.mission.waypoint_file import parse_waypoints, waypoints_text

LARGEST_FILE_BYTES = 20_000_000
_WAYPOINT_SUFFIXES = (".waypoints", ".wpl", ".txt")


def read_plan(path: Path) -> Plan:
    """The plan in a `.plan` or `QGC WPL` file; its content tells which it is.

    Raises:
        InputError: it cannot be read, is too large, or something in it is wrong; names the key or the line.
    """
    content = read_bounded(path, LARGEST_FILE_BYTES)
    with naming(str(path)):
        if content.lstrip()[:1] == b"{":
            return parse_plan(content)
        try:
            return parse_waypoints(content.decode("utf-8-sig"))
        except UnicodeDecodeError:
            raise InputError("neither a .plan of QGroundControl nor a QGC WPL file") from None


def write_plan(plan: Plan, path: Path) -> None:
    """Write `plan` in the format that the name of the file asks for.

    Raises:
        InputError: the name asks for none that is known, the format cannot hold the plan, or nothing can be
            written there.
    """
    suffix = path.suffix.lower()
    if suffix not in (".plan", *_WAYPOINT_SUFFIXES):
        raise InputError(f"{path}: name it .plan, or one of {', '.join(_WAYPOINT_SUFFIXES)}")
    with naming(str(path)):
        text = plan_text(plan) if suffix == ".plan" else waypoints_text(plan)
        try:
            path.write_text(text, encoding="utf-8")
        except OSError as error:
            raise InputError(f"cannot be written: {error.strerror}") from error
