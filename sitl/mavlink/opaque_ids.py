"""Mission messages with the ids of plans, which pymavlink's dialects do not know yet.

MISSION_ACK and MISSION_COUNT end in `opaque_id`, MISSION_CURRENT in `mission_id`, `fence_id` and
`rally_points_id`: extension fields of https://mavlink.io/en/messages/common.html, 4 bytes each.
"""

import struct

from pymavlink.dialects.v20 import common as mavlink


class MissionAck(mavlink.MAVLink_mission_ack_message):
    """MISSION_ACK, with the id of the plan that has been accepted."""

    def __init__(self, system: int, component: int, result: int, kind: int, opaque_id: int) -> None:
        super().__init__(system, component, result, kind)
        self.opaque_id = opaque_id

    def pack(self, mav: mavlink.MAVLink, force_mavlink1: bool = False) -> bytes:
        """The frame."""
        fields = (self.target_system, self.target_component, self.type, self.mission_type, self.opaque_id)
        return _frame(self, mav, struct.pack("<4BI", *fields), force_mavlink1)


class MissionCount(mavlink.MAVLink_mission_count_message):
    """MISSION_COUNT, with the id of the plan that is on board."""

    def __init__(self, system: int, component: int, count: int, kind: int, opaque_id: int) -> None:
        super().__init__(system, component, count, kind)
        self.opaque_id = opaque_id

    def pack(self, mav: mavlink.MAVLink, force_mavlink1: bool = False) -> bytes:
        """The frame."""
        fields = (self.count, self.target_system, self.target_component, self.mission_type, self.opaque_id)
        return _frame(self, mav, struct.pack("<H3BI", *fields), force_mavlink1)


class MissionCurrent(mavlink.MAVLink_mission_current_message):
    """MISSION_CURRENT, with the ids of mission, fence and rally points."""

    def __init__(self, seq: int, total: int, state: int, mode: int, ids: tuple[int, int, int]) -> None:
        super().__init__(seq, total, state, mode)
        self.mission_id, self.fence_id, self.rally_points_id = ids

    def pack(self, mav: mavlink.MAVLink, force_mavlink1: bool = False) -> bytes:
        """The frame."""
        ids = (self.mission_id, self.fence_id, self.rally_points_id)
        payload = struct.pack("<HHBB3I", self.seq, self.total, self.mission_state, self.mission_mode, *ids)
        return _frame(self, mav, payload, force_mavlink1)


def _frame(
    message: mavlink.MAVLink_message, mav: mavlink.MAVLink, payload: bytes, force_mavlink1: bool
) -> bytes:
    frame: bytes = message._pack(mav, message.crc_extra, payload, force_mavlink1=force_mavlink1)
    return frame
