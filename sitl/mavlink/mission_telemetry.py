"""What the vehicle tells of its mission and its fence."""

from collections.abc import Mapping
from typing import cast

from pymavlink.dialects.v20 import common as mavlink
from pymavlink.dialects.v20.ardupilotmega import MAVLink_fence_status_message

from sitl.firmware.interface import Mode
from sitl.mavlink.frames import Message
from sitl.mavlink.opaque_ids import MissionCurrent
from sitl.mavlink.telemetry import Report
from sitl.plan.items import PlanKind

FENCE_STATUS = MAVLink_fence_status_message.id

_IN_MISSION_MODE, _NOT_IN_MISSION_MODE = 1, 2
_NO_MISSION = 65535
_BREACHES: Mapping[str, int] = {
    "": mavlink.FENCE_BREACH_NONE,
    "altitude": mavlink.FENCE_BREACH_MAXALT,
    "distance": mavlink.FENCE_BREACH_BOUNDARY,
    "boundary": mavlink.FENCE_BREACH_BOUNDARY,
}


def px4_mission_current(state: Report) -> Message:
    """MISSION_CURRENT: which item is flown, how far the mission is, and which plans are on board."""
    plans = state.firmware.plans
    flies = state.firmware.mode is Mode.MISSION
    mode = _IN_MISSION_MODE if flies else _NOT_IN_MISSION_MODE
    ids = (plans[kind].opaque_id for kind in (PlanKind.MISSION, PlanKind.FENCE, PlanKind.RALLY))
    mission_id, fence_id, rally_id = ids
    total = len(plans[PlanKind.MISSION]) or _NO_MISSION
    state_now = plans.mission.state.value
    return MissionCurrent(plans.mission.current, total, state_now, mode, (mission_id, fence_id, rally_id))


def ardupilot_mission_current(state: Report) -> Message:
    """MISSION_CURRENT: ArduPilot does not count home, and tells no ids."""
    plans = state.firmware.plans
    total = max(0, len(plans[PlanKind.MISSION]) - 1)
    mode = int(state.firmware.mode is Mode.MISSION)
    current = plans.mission.current if total else 0
    return mavlink.MAVLink_mission_current_message(current, total, plans.mission.state.value, mode)


def fence_status(state: Report) -> Message:
    """FENCE_STATUS: whether the fence is broken now, and how often it was."""
    fence = state.firmware.fence_status
    message = MAVLink_fence_status_message(
        int(bool(fence.breach)), fence.count, _BREACHES[fence.breach], round(fence.since_s * 1e3)
    )
    return cast(Message, message)  # pymavlink gives each dialect a base class of its own
