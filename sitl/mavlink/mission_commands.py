"""The commands that act on missions, the fence, home and speed."""

import math
from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np
from pymavlink.dialects.v20 import common as mavlink

from sitl.mavlink import missions
from sitl.mavlink.commands import Command, local_place, whole
from sitl.mavlink.flavour import Execute

if TYPE_CHECKING:
    from sitl.mavlink.session import Session

_CURRENT_PLACE = 1
_GROUND_SPEEDS = (mavlink.SPEED_TYPE_AIRSPEED, mavlink.SPEED_TYPE_GROUNDSPEED)


def _start_px4_mission(session: "Session", command: Command) -> int:
    """From item param1; -1 goes on where the mission is."""
    first = whole(command.params[0])
    if first < -1:
        return mavlink.MAV_RESULT_DENIED
    return session.result(session.firmware.start_mission(first if first >= 0 else None))


def _start_ardupilot_mission(session: "Session", command: Command) -> int:
    """ArduPilot takes no first and no last item."""
    if any(whole(value) > 0 for value in command.params[:2]):
        return mavlink.MAV_RESULT_DENIED
    return session.result(session.firmware.start_mission())


def _set_mission_current(session: "Session", command: Command) -> int:
    """To item param1; with param2 = 1 all jumps are still to be made, and -1 is the beginning."""
    number = whole(command.params[0])
    mission = session.firmware.plans.mission
    if number < -1 or number >= len(mission.plan):
        return mavlink.MAV_RESULT_DENIED
    if command.params[1] == 1.0:
        mission.restart()
    if number >= 0:
        missions.set_current(session, number)
    return mavlink.MAV_RESULT_ACCEPTED


def _change_speed(session: "Session", command: Command) -> int:
    """Ground speed; climb and descent keep their own."""
    kind, speed_m_s = whole(command.params[0]), command.params[1]
    if kind not in _GROUND_SPEEDS:
        return mavlink.MAV_RESULT_UNSUPPORTED
    if not math.isfinite(speed_m_s):
        return mavlink.MAV_RESULT_DENIED
    return session.result(session.firmware.change_speed(speed_m_s))


def _set_home(session: "Session", command: Command) -> int:
    """To the present place, or to the one given."""
    plans = session.firmware.plans
    if whole(command.params[0]) == _CURRENT_PLACE:
        plans.home = session.firmware.estimate.position.copy()
    else:
        place = local_place(session, command)
        if place is None or not np.isfinite(place).all():
            return mavlink.MAV_RESULT_DENIED
        plans.home = np.array(place)
    session.send(session.flavour.writers[mavlink.MAVLINK_MSG_ID_HOME_POSITION](session.report()))
    return mavlink.MAV_RESULT_ACCEPTED


def _enable_fence(session: "Session", command: Command) -> int:
    match whole(command.params[0]):
        case 0 | 1 as wanted:
            return session.result(session.firmware.enable_fence(enabled=bool(wanted)))
        case _:
            return mavlink.MAV_RESULT_FAILED


_COMMANDS: Mapping[int, Execute] = {
    mavlink.MAV_CMD_DO_SET_MISSION_CURRENT: _set_mission_current,
    mavlink.MAV_CMD_DO_CHANGE_SPEED: _change_speed,
    mavlink.MAV_CMD_DO_SET_HOME: _set_home,
}
PX4_COMMANDS: Mapping[int, Execute] = {
    **_COMMANDS,
    mavlink.MAV_CMD_MISSION_START: _start_px4_mission,
}
ARDUPILOT_COMMANDS: Mapping[int, Execute] = {
    **_COMMANDS,
    mavlink.MAV_CMD_MISSION_START: _start_ardupilot_mission,
    mavlink.MAV_CMD_DO_FENCE_ENABLE: _enable_fence,
}
