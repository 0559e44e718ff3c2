"""Which plan items PX4 and ArduPilot take, and what they answer to the others (MAV_MISSION_RESULT).

PX4: `MavlinkMissionManager::parse_mavlink_mission_item`. ArduPilot: `AP_Mission::mavlink_int_to_mission_cmd`,
`sanity_check_params`, and the fence and rally parts of `MissionItemProtocol`.
"""

import math
from collections.abc import Mapping

from pymavlink.dialects.v20 import common as mavlink

from sitl.plan.items import Command, Item, PlanKind
from sitl.plan.places import ABOVE_HOME, ABOVE_SEA, GLOBAL

_ACCEPTED = mavlink.MAV_MISSION_ACCEPTED
_NO_PLACE = 2**31 - 1
_HIGHEST_M = 83_000.0
"""LOCATION_ALT_MAX_M of ArduPilot."""

_FENCE_POLYGONS = frozenset((Command.FENCE_INCLUSION_VERTEX, Command.FENCE_EXCLUSION_VERTEX))
_FENCE_CIRCLES = frozenset((Command.FENCE_INCLUSION_CIRCLE, Command.FENCE_EXCLUSION_CIRCLE))
_OF_KIND: Mapping[PlanKind, frozenset[int]] = {
    PlanKind.FENCE: _FENCE_POLYGONS | _FENCE_CIRCLES | {Command.FENCE_RETURN_POINT},
    PlanKind.RALLY: frozenset((Command.RALLY_POINT,)),
}

_PX4_PLACED = frozenset(
    (
        mavlink.MAV_CMD_NAV_WAYPOINT,
        mavlink.MAV_CMD_NAV_LOITER_UNLIM,
        mavlink.MAV_CMD_NAV_LOITER_TIME,
        mavlink.MAV_CMD_NAV_LAND,
        mavlink.MAV_CMD_NAV_TAKEOFF,
        mavlink.MAV_CMD_NAV_LOITER_TO_ALT,
        mavlink.MAV_CMD_NAV_ROI,
        mavlink.MAV_CMD_DO_SET_ROI,
        mavlink.MAV_CMD_DO_SET_ROI_LOCATION,
        mavlink.MAV_CMD_CONDITION_GATE,
    )
)
_CAMERA_AND_GIMBAL = frozenset(
    (
        mavlink.MAV_CMD_DO_SET_ROI,
        mavlink.MAV_CMD_DO_SET_ROI_NONE,
        mavlink.MAV_CMD_DO_SET_ROI_WPNEXT_OFFSET,
        mavlink.MAV_CMD_DO_DIGICAM_CONTROL,
        mavlink.MAV_CMD_DO_MOUNT_CONTROL,
        mavlink.MAV_CMD_DO_GIMBAL_MANAGER_PITCHYAW,
        mavlink.MAV_CMD_SET_CAMERA_ZOOM,
        mavlink.MAV_CMD_SET_CAMERA_FOCUS,
        mavlink.MAV_CMD_IMAGE_START_CAPTURE,
        mavlink.MAV_CMD_IMAGE_STOP_CAPTURE,
        mavlink.MAV_CMD_VIDEO_START_CAPTURE,
        mavlink.MAV_CMD_VIDEO_STOP_CAPTURE,
        mavlink.MAV_CMD_DO_SET_CAM_TRIGG_DIST,
    )
)
_PX4_COMMANDS = _CAMERA_AND_GIMBAL | {
    mavlink.MAV_CMD_NAV_ROI,
    mavlink.MAV_CMD_DO_JUMP,
    mavlink.MAV_CMD_DO_WINCH,
    mavlink.MAV_CMD_DO_GRIPPER,
    mavlink.MAV_CMD_DO_CHANGE_SPEED,
    mavlink.MAV_CMD_DO_SET_HOME,
    mavlink.MAV_CMD_DO_LAND_START,
    mavlink.MAV_CMD_DO_TRIGGER_CONTROL,
    mavlink.MAV_CMD_DO_MOUNT_CONFIGURE,
    mavlink.MAV_CMD_DO_GIMBAL_MANAGER_CONFIGURE,
    mavlink.MAV_CMD_DO_CONTROL_VIDEO,
    mavlink.MAV_CMD_DO_SET_CAM_TRIGG_INTERVAL,
    mavlink.MAV_CMD_SET_CAMERA_MODE,
    mavlink.MAV_CMD_OBLIQUE_SURVEY,
    mavlink.MAV_CMD_NAV_DELAY,
    mavlink.MAV_CMD_NAV_RETURN_TO_LAUNCH,
    mavlink.MAV_CMD_CONDITION_DELAY,
    mavlink.MAV_CMD_CONDITION_DISTANCE,
    mavlink.MAV_CMD_DO_SET_ACTUATOR,
}
_ARDUPILOT_PLACED = frozenset(
    (
        mavlink.MAV_CMD_NAV_WAYPOINT,
        mavlink.MAV_CMD_NAV_LOITER_UNLIM,
        mavlink.MAV_CMD_NAV_LOITER_TURNS,
        mavlink.MAV_CMD_NAV_LOITER_TIME,
        mavlink.MAV_CMD_NAV_LAND,
        mavlink.MAV_CMD_NAV_TAKEOFF,
        mavlink.MAV_CMD_NAV_LOITER_TO_ALT,
        mavlink.MAV_CMD_NAV_SPLINE_WAYPOINT,
        mavlink.MAV_CMD_DO_SET_HOME,
        mavlink.MAV_CMD_DO_SET_ROI,
        mavlink.MAV_CMD_DO_SET_ROI_LOCATION,
        mavlink.MAV_CMD_DO_LAND_START,
    )
)
_ARDUPILOT_COMMANDS = _CAMERA_AND_GIMBAL | {
    mavlink.MAV_CMD_NAV_RETURN_TO_LAUNCH,
    mavlink.MAV_CMD_NAV_DELAY,
    mavlink.MAV_CMD_NAV_GUIDED_ENABLE,
    mavlink.MAV_CMD_CONDITION_DELAY,
    mavlink.MAV_CMD_CONDITION_DISTANCE,
    mavlink.MAV_CMD_CONDITION_YAW,
    mavlink.MAV_CMD_DO_JUMP,
    mavlink.MAV_CMD_DO_CHANGE_SPEED,
    mavlink.MAV_CMD_DO_SET_RELAY,
    mavlink.MAV_CMD_DO_REPEAT_RELAY,
    mavlink.MAV_CMD_DO_SET_SERVO,
    mavlink.MAV_CMD_DO_REPEAT_SERVO,
    mavlink.MAV_CMD_DO_FENCE_ENABLE,
    mavlink.MAV_CMD_DO_GRIPPER,
    mavlink.MAV_CMD_DO_WINCH,
    mavlink.MAV_CMD_DO_PARACHUTE,
    mavlink.MAV_CMD_DO_ENGINE_CONTROL,
    mavlink.MAV_CMD_DO_GUIDED_LIMITS,
    mavlink.MAV_CMD_JUMP_TAG,
    mavlink.MAV_CMD_DO_JUMP_TAG,
}
_YAW_MAY_BE_NAN = frozenset(
    (mavlink.MAV_CMD_NAV_WAYPOINT, mavlink.MAV_CMD_NAV_LAND, mavlink.MAV_CMD_NAV_TAKEOFF)
)


def check_px4(kind: PlanKind, item: Item) -> int:
    """What PX4 answers to an item."""
    if item.frame in ABOVE_SEA + ABOVE_HOME:
        known = item.command in _OF_KIND.get(kind, _PX4_PLACED)
        if not known:
            return _stray(kind, item)
        if item.command in (mavlink.MAV_CMD_NAV_ROI, mavlink.MAV_CMD_DO_SET_ROI):
            if round(item.param(1)) not in (mavlink.MAV_ROI_NONE, mavlink.MAV_ROI_LOCATION):
                return mavlink.MAV_MISSION_INVALID_PARAM1
        elif kind is PlanKind.FENCE and item.command in _FENCE_POLYGONS and round(item.param(1)) < 3:
            return mavlink.MAV_MISSION_ERROR
        return _check_place(item)
    if item.frame != mavlink.MAV_FRAME_MISSION:
        return mavlink.MAV_MISSION_UNSUPPORTED_FRAME
    known = kind is PlanKind.MISSION and item.command in _PX4_COMMANDS
    return _ACCEPTED if known else mavlink.MAV_MISSION_UNSUPPORTED


def _stray(kind: PlanKind, item: Item) -> int:
    """A fence or rally item in another plan is an error, any other command unknown."""
    elsewhere = any(item.command in commands for commands in _OF_KIND.values())
    misplaced = elsewhere and kind is PlanKind.MISSION
    return mavlink.MAV_MISSION_ERROR if misplaced else mavlink.MAV_MISSION_UNSUPPORTED


def check_ardupilot(kind: PlanKind, item: Item) -> int:
    """What ArduPilot answers to an item."""
    if kind is not PlanKind.MISSION:
        return _check_ardupilot_area(kind, item)
    placed = item.command in _ARDUPILOT_PLACED
    if not placed and item.command not in _ARDUPILOT_COMMANDS:
        return mavlink.MAV_MISSION_UNSUPPORTED
    for number, value in enumerate(item.params):
        if math.isnan(value) and not (number == 3 and item.command in _YAW_MAY_BE_NAN):
            return mavlink.MAV_MISSION_INVALID_PARAM1 + number
    if not placed:
        return _ACCEPTED
    if item.frame not in (*GLOBAL, mavlink.MAV_FRAME_MISSION):
        return mavlink.MAV_MISSION_UNSUPPORTED_FRAME
    return _check_place(item)


def _check_ardupilot_area(kind: PlanKind, item: Item) -> int:
    if item.command not in _OF_KIND[kind]:
        return mavlink.MAV_MISSION_UNSUPPORTED
    if item.frame not in ABOVE_SEA + ABOVE_HOME:
        return mavlink.MAV_MISSION_UNSUPPORTED_FRAME
    if item.command in _FENCE_POLYGONS and round(item.param(1)) < 3:
        return mavlink.MAV_MISSION_INVALID_PARAM1
    if item.command in _FENCE_CIRCLES and not item.param(1) > 0.0:
        return mavlink.MAV_MISSION_INVALID_PARAM1
    return _check_place(item)


def _check_place(item: Item) -> int:
    if not item.x == item.y == _NO_PLACE:
        if abs(item.x) > 900_000_000:
            return mavlink.MAV_MISSION_INVALID_PARAM5_X
        if abs(item.y) > 1_800_000_000:
            return mavlink.MAV_MISSION_INVALID_PARAM6_Y
    return _ACCEPTED if abs(item.z) < _HIGHEST_M else mavlink.MAV_MISSION_INVALID_PARAM7
