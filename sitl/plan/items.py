"""Plan items as MAVLink has them, and plans made of them.

Firmware keeps what was uploaded in the terms of the upload: so a download gives it back to the bit, and an
altitude above home means the home of the moment in which the item is flown. See `sitl.plan.places` for local
coordinates.
"""

import math
import struct
import zlib
from dataclasses import dataclass
from enum import IntEnum
from functools import cached_property


class PlanKind(IntEnum):
    """What a plan is for (MAV_MISSION_TYPE)."""

    MISSION = 0
    FENCE = 1
    RALLY = 2


class Command(IntEnum):
    """The commands of items that mean something on board (MAV_CMD); the others are only carried."""

    NAV_WAYPOINT = 16
    NAV_LOITER_UNLIM = 17
    NAV_LOITER_TURNS = 18
    NAV_LOITER_TIME = 19
    NAV_RETURN_TO_LAUNCH = 20
    NAV_LAND = 21
    NAV_TAKEOFF = 22
    NAV_LOITER_TO_ALT = 31
    NAV_SPLINE_WAYPOINT = 82
    NAV_DELAY = 93
    LAST_NAV = 95
    CONDITION_DELAY = 112
    LAST_CONDITION = 159
    DO_JUMP = 177
    DO_CHANGE_SPEED = 178
    DO_SET_HOME = 179
    DO_LAND_START = 189
    DO_SET_ROI_LOCATION = 195
    DO_SET_ROI_NONE = 197
    DO_SET_ROI = 201
    DO_FENCE_ENABLE = 207
    FENCE_RETURN_POINT = 5000
    FENCE_INCLUSION_VERTEX = 5001
    FENCE_EXCLUSION_VERTEX = 5002
    FENCE_INCLUSION_CIRCLE = 5003
    FENCE_EXCLUSION_CIRCLE = 5004
    RALLY_POINT = 5100


LOOKS = frozenset((Command.DO_SET_ROI_LOCATION, Command.DO_SET_ROI_NONE, Command.DO_SET_ROI))
"""Commands that say where to look."""


@dataclass(frozen=True, slots=True)
class Item:
    """One item, field for field as MISSION_ITEM_INT has it.

    Attributes:
        command: MAV_CMD.
        frame: MAV_FRAME of x, y, z.
        params: the first four parameters.
        x, y: latitude and longitude (1e-7 degrees), or what the command makes of them.
        z: altitude (m).
        autocontinue: whether the next item follows by itself.
    """

    command: int
    frame: int
    params: tuple[float, float, float, float] = (0.0, 0.0, 0.0, 0.0)
    x: int = 0
    y: int = 0
    z: float = 0.0
    autocontinue: bool = True

    @property
    def is_navigation(self) -> bool:
        """Whether it is flown, until it is reached or done."""
        return self.command <= Command.LAST_NAV

    def param(self, number: int, default: float = 0.0) -> float:
        """A parameter by its number (1 to 4); `default` for one that is NaN."""
        value = self.params[number - 1]
        return default if math.isnan(value) else value


@dataclass(frozen=True)
class Plan:
    """Items of one kind, in their order."""

    items: tuple[Item, ...] = ()

    def __len__(self) -> int:
        return len(self.items)

    @cached_property
    def opaque_id(self) -> int:
        """Tells this plan from others (a CRC, as in PX4); 0 for no items, and for nothing else."""
        checksum = 0
        for item in self.items:
            packed = struct.pack(
                "<HB?4fiif",
                item.command,
                item.frame,
                item.autocontinue,
                *item.params,
                item.x,
                item.y,
                item.z,
            )
            checksum = zlib.crc32(packed, checksum)
        return checksum or len(self.items)
