"""ArduPilot Copter's own names of the modes that it has here."""

from collections.abc import Mapping

from sitl.firmware.interface import Mode
from sitl.plan.mission import Mission

MODE_NAMES: Mapping[Mode, str] = {
    Mode.STABILIZE: "STABILIZE",
    Mode.HOLD: "LOITER",
    Mode.BRAKE: "BRAKE",
    Mode.OFFBOARD: "GUIDED",
    Mode.LAND: "LAND",
    Mode.RTL: "RTL",
    Mode.MISSION: "AUTO",
}

EQUIVALENTS: Mapping[Mode, Mode] = {Mode.POSCTL: Mode.HOLD}
"""What ArduPilot has for PX4's modes: LOITER is both, held while the sticks are in their middle."""


def reason_not_to_enter(
    mode: Mode, mission: Mission, armed: bool, *, in_flight: bool, position_ok: bool
) -> str | None:
    """Why a mode cannot be chosen now; None when it can."""
    if mode not in MODE_NAMES:
        return "no such mode"
    if mode is Mode.STABILIZE:
        return "no pilot" if in_flight else None
    if mode is Mode.MISSION and not mission.exists:
        return "no mission"
    if mode is Mode.MISSION and armed and not in_flight:
        return None if mission.starts_with_takeoff else "Auto: Missing Takeoff Cmd"
    return None if position_ok or mode is Mode.LAND else "requires position"
