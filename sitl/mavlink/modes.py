"""Flight modes as PX4 writes them into HEARTBEAT, DO_SET_MODE and SET_MODE.

custom_mode = main mode << 16 | sub mode << 24 (px4_custom_mode.h).
"""

from pymavlink.dialects.v20 import common as mavlink

from sitl.firmware.interface import Mode

_PX4_MODES: dict[Mode, tuple[int, int]] = {
    Mode.POSCTL: (3, 0),
    Mode.TAKEOFF: (4, 2),
    Mode.HOLD: (4, 3),
    Mode.RTL: (4, 5),
    Mode.LAND: (4, 6),
    Mode.OFFBOARD: (6, 0),
}
_MODES = {main_and_sub: mode for mode, main_and_sub in _PX4_MODES.items()}

_PILOTED = (
    mavlink.MAV_MODE_FLAG_CUSTOM_MODE_ENABLED
    | mavlink.MAV_MODE_FLAG_STABILIZE_ENABLED
    | mavlink.MAV_MODE_FLAG_MANUAL_INPUT_ENABLED
)
_AUTOMATIC = (
    mavlink.MAV_MODE_FLAG_CUSTOM_MODE_ENABLED
    | mavlink.MAV_MODE_FLAG_STABILIZE_ENABLED
    | mavlink.MAV_MODE_FLAG_GUIDED_ENABLED
    | mavlink.MAV_MODE_FLAG_AUTO_ENABLED
)


def custom_mode(mode: Mode) -> int:
    """HEARTBEAT.custom_mode of a flight mode."""
    main, sub = _PX4_MODES[mode]
    return main << 16 | sub << 24


def base_mode(mode: Mode, *, armed: bool) -> int:
    """HEARTBEAT.base_mode of a flight mode."""
    flags = _PILOTED if mode is Mode.POSCTL else _AUTOMATIC
    return flags | mavlink.MAV_MODE_FLAG_SAFETY_ARMED if armed else flags


def mode_from_px4(main: int, sub: int) -> Mode | None:
    """The flight mode with these PX4 numbers; None for one that this vehicle does not have."""
    return _MODES.get((main, sub))
