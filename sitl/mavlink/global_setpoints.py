"""Setpoints on the map: SET_POSITION_TARGET_GLOBAL_INT as the local one that means the same."""

from typing import TYPE_CHECKING

from pymavlink.dialects.v20 import common as mavlink

from sitl.geodesy import Geodetic
from sitl.mavlink.commands import Command, local_place

if TYPE_CHECKING:
    from sitl.mavlink.session import Session

_TERRAIN_IS_HOME = {
    mavlink.MAV_FRAME_GLOBAL_TERRAIN_ALT: mavlink.MAV_FRAME_GLOBAL_RELATIVE_ALT,
    mavlink.MAV_FRAME_GLOBAL_TERRAIN_ALT_INT: mavlink.MAV_FRAME_GLOBAL_RELATIVE_ALT_INT,
}
"""The ground is as high as home everywhere."""


def as_local(
    session: "Session", message: mavlink.MAVLink_set_position_target_global_int_message
) -> mavlink.MAVLink_set_position_target_local_ned_message | None:
    """The setpoint in MAV_FRAME_LOCAL_NED; None for a place that is none on earth, or a frame without any."""
    frame = _TERRAIN_IS_HOME.get(message.coordinate_frame, message.coordinate_frame)
    place = Geodetic(message.lat_int * 1e-7, message.lon_int * 1e-7, message.alt)
    local = local_place(session, Command(0, (0.0,) * 4, place, frame))
    if local is None:
        return None
    return mavlink.MAVLink_set_position_target_local_ned_message(
        message.time_boot_ms,
        message.target_system,
        message.target_component,
        mavlink.MAV_FRAME_LOCAL_NED,
        message.type_mask,
        *local,
        message.vx,
        message.vy,
        message.vz,
        message.afx,
        message.afy,
        message.afz,
        message.yaw,
        message.yaw_rate,
    )
