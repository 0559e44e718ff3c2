"""What moves an ArduPilot in GUIDED beside setpoints: places, headings, a hold (its GCS_Mavlink.cpp)."""

import math
from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np
from pymavlink.dialects.v20 import common as mavlink

from sitl import quaternion
from sitl.firmware.interface import Mode, Result
from sitl.geodesy import Geodetic
from sitl.mavlink import missions
from sitl.mavlink.commands import Command, local_place, whole
from sitl.mavlink.flavour import Execute

if TYPE_CHECKING:
    from sitl.mavlink.session import Session

_GUIDED_ITEM = 2
"""MISSION_ITEM.current of an item that is no part of a mission: where to go now."""
_COUNTER_CLOCKWISE = -1


def _reposition(session: "Session", command: Command) -> int:
    """To a place; into GUIDED only where the flags say so."""
    place = local_place(session, command)
    may_change = whole(command.params[1]) == mavlink.MAV_DO_REPOSITION_FLAGS_CHANGE_MODE
    if place is None or not (may_change or session.firmware.mode is Mode.OFFBOARD):
        return mavlink.MAV_RESULT_DENIED
    yaw = command.params[3] if math.isfinite(command.params[3]) else math.nan
    return session.result(session.firmware.reposition(np.array(place), yaw))


def _turn(session: "Session", command: Command) -> int:
    """To a heading from 0 to 360 degrees, or by an angle."""
    angle_deg, _, direction, relative = command.params
    if not 0.0 <= angle_deg <= 360.0 or relative not in (0.0, 1.0):
        return mavlink.MAV_RESULT_FAILED
    yaw = math.radians(angle_deg)
    if relative:
        sign = -1.0 if direction == _COUNTER_CLOCKWISE else 1.0
        yaw = quaternion.yaw_of(session.firmware.estimate.attitude) + sign * yaw
    return session.result(session.firmware.turn(yaw))


def _loiter(session: "Session", command: Command) -> int:
    return session.result(session.firmware.set_mode(Mode.HOLD))


COMMANDS: Mapping[int, Execute] = {
    mavlink.MAV_CMD_DO_REPOSITION: _reposition,
    mavlink.MAV_CMD_CONDITION_YAW: _turn,
    mavlink.MAV_CMD_NAV_LOITER_UNLIM: _loiter,
}


def on_item(session: "Session", message: mavlink.MAVLink_mission_item_message) -> None:
    """A place to go to, or an item of a mission."""
    if message.current == _GUIDED_ITEM:
        _go_to(session, message, Geodetic(message.x, message.y, message.z))
    else:
        missions.on_item(session, message)


def on_item_int(session: "Session", message: mavlink.MAVLink_mission_item_int_message) -> None:
    """The same with whole numbers."""
    if message.current == _GUIDED_ITEM:
        _go_to(session, message, Geodetic(message.x * 1e-7, message.y * 1e-7, message.z))
    else:
        missions.on_item_int(session, message)


def _go_to(
    session: "Session",
    message: mavlink.MAVLink_mission_item_message | mavlink.MAVLink_mission_item_int_message,
    place: Geodetic,
) -> None:
    """Fly there, if the mode is GUIDED already."""
    if not session.accepts(message.target_system, message.target_component):
        return
    local = local_place(session, Command(message.command, (0.0,) * 4, place, message.frame))
    guided = session.firmware.mode is Mode.OFFBOARD
    flies = (
        guided
        and local is not None
        and session.firmware.reposition(np.array(local), math.nan) is Result.ACCEPTED
    )
    session.send(
        mavlink.MAVLink_mission_ack_message(
            message.get_srcSystem(),
            message.get_srcComponent(),
            mavlink.MAV_MISSION_ACCEPTED if flies else mavlink.MAV_MISSION_ERROR,
        )
    )
