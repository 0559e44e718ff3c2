"""How PX4 and ArduPilot conduct plan transfers."""

from pymavlink.dialects.v20 import common as mavlink

from sitl.mavlink.mission_items import check_ardupilot, check_px4
from sitl.mavlink.mission_upload import MissionWire
from sitl.plan.items import PlanKind

PX4_MISSIONS = MissionWire(
    request=mavlink.MAVLink_mission_request_int_message,
    retry_s=0.25,
    timeout_s=5.0,
    capacity={PlanKind.MISSION: 2000, PlanKind.FENCE: 64, PlanKind.RALLY: 32},
    atomic=frozenset(PlanKind),
    refuses_out_of_turn=False,
    has_home=False,
    busy=mavlink.MAV_MISSION_ERROR,
    check=check_px4,
    frames={
        mavlink.MAV_FRAME_GLOBAL: mavlink.MAV_FRAME_GLOBAL_INT,
        mavlink.MAV_FRAME_GLOBAL_RELATIVE_ALT: mavlink.MAV_FRAME_GLOBAL_RELATIVE_ALT_INT,
    },
    has_ids=True,
)
"""`mavlink_mission.cpp`; the sizes are those of its dataman in simulation."""

ARDUPILOT_MISSIONS = MissionWire(
    request=mavlink.MAVLink_mission_request_message,
    retry_s=1.0,
    timeout_s=8.0,
    capacity={PlanKind.MISSION: 2184, PlanKind.FENCE: 84, PlanKind.RALLY: 25},
    atomic=frozenset((PlanKind.FENCE,)),
    refuses_out_of_turn=True,
    has_home=True,
    busy=mavlink.MAV_MISSION_DENIED,
    check=check_ardupilot,
    frames={
        mavlink.MAV_FRAME_GLOBAL_INT: mavlink.MAV_FRAME_GLOBAL,
        mavlink.MAV_FRAME_GLOBAL_RELATIVE_ALT_INT: mavlink.MAV_FRAME_GLOBAL_RELATIVE_ALT,
        mavlink.MAV_FRAME_GLOBAL_TERRAIN_ALT_INT: mavlink.MAV_FRAME_GLOBAL_TERRAIN_ALT,
    },
    has_ids=False,
)
"""`MissionItemProtocol.cpp`; missions as large as with 32 KiB for them on the card (BRD_SD_MISSION)."""
