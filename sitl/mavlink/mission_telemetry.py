"""What the vehicle tells of its mission and its fence."""

from collections.abc import Mapping
from typing import cast

from pymavlink.dialects.v20 import common as mavlink
from pymavlink.dialects.v20.ardupilotmega import MAVLink_fence_status_message

from sitl.firmware.interface import Mode
from sitl.mavlink.flavour import Flavour
from sitl.mavlink.frames import Message
from sitl.mavlink.opaque_ids import MissionCurrent
from sitl.mavlink.telemetry import Report
from sitl.plan.items import Plan, PlanKind

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


class MissionNews:
    """What is told of a mission beside the streams: which items were reached, and which one is current now.

    PX4 tells the item that was reached last again once a second, so that no lost frame conceals it
    (`MavlinkMissionManager::send`).
    """

    def __init__(self, flavour: Flavour) -> None:
        self._flavour = flavour
        self._plan: Plan | None = None
        self._current = 0
        self._last = 0
        self._repeats = 0
        self._due_s = 0.0

    def take(self, state: Report) -> list[Message]:
        """The messages that are due now, for every link."""
        mission = state.firmware.plans.mission
        if mission.plan is not self._plan:
            self._plan, self._current, self._repeats = mission.plan, mission.current, 0
        reached = mission.take_reached()
        if reached:
            self._last, self._repeats = reached[-1], self._flavour.reached_repeats
            self._due_s = state.time_s + 1.0
        elif self._repeats and state.time_s >= self._due_s:
            reached = [self._last]
            self._repeats -= 1
            self._due_s += 1.0
        news: list[Message] = [mavlink.MAVLink_mission_item_reached_message(number) for number in reached]
        if mission.current != self._current:
            self._current = mission.current
            if self._flavour.tells_current_at_once:
                news.append(self._flavour.writers[mavlink.MAVLINK_MSG_ID_MISSION_CURRENT](state))
        return news
