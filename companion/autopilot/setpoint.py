"""SET_POSITION_TARGET_LOCAL_NED, as PX4 and ArduPilot both take it."""

from companion.arrays import Vec3
from companion.link.dialect import mavlink

_IGNORE_POSITION = (
    mavlink.POSITION_TARGET_TYPEMASK_X_IGNORE
    | mavlink.POSITION_TARGET_TYPEMASK_Y_IGNORE
    | mavlink.POSITION_TARGET_TYPEMASK_Z_IGNORE
)
_IGNORE_VELOCITY = (
    mavlink.POSITION_TARGET_TYPEMASK_VX_IGNORE
    | mavlink.POSITION_TARGET_TYPEMASK_VY_IGNORE
    | mavlink.POSITION_TARGET_TYPEMASK_VZ_IGNORE
)
_IGNORE_ACCELERATION = (
    mavlink.POSITION_TARGET_TYPEMASK_AX_IGNORE
    | mavlink.POSITION_TARGET_TYPEMASK_AY_IGNORE
    | mavlink.POSITION_TARGET_TYPEMASK_AZ_IGNORE
)
_NOTHING = (0.0, 0.0, 0.0)


def position_target(
    target: tuple[int, int],
    time_s: float,
    position: Vec3 | None,
    velocity: Vec3 | None,
    acceleration: Vec3 | None,
    yaw: float | None,
) -> mavlink.MAVLink_set_position_target_local_ned_message:
    """The message for `target` (system, component) that sets what is given and masks what is None.

    `time_s` is our own clock's (s); position, velocity, acceleration and yaw are NED, SI, rad.
    """
    mask = mavlink.POSITION_TARGET_TYPEMASK_YAW_RATE_IGNORE
    if position is None:
        mask |= _IGNORE_POSITION
    if velocity is None:
        mask |= _IGNORE_VELOCITY
    if acceleration is None:
        mask |= _IGNORE_ACCELERATION
    if yaw is None:
        mask |= mavlink.POSITION_TARGET_TYPEMASK_YAW_IGNORE
    x, y, z = _NOTHING if position is None else position.tolist()
    vx, vy, vz = _NOTHING if velocity is None else velocity.tolist()
    ax, ay, az = _NOTHING if acceleration is None else acceleration.tolist()
    return mavlink.MAVLink_set_position_target_local_ned_message(
        round(time_s * 1e3) & 0xFFFFFFFF,
        *target,
        mavlink.MAV_FRAME_LOCAL_NED,
        mask,
        *(x, y, z),
        *(vx, vy, vz),
        *(ax, ay, az),
        yaw=0.0 if yaw is None else yaw,
        yaw_rate=0.0,
    )
