"""Why PX4 refuses to arm or to enter a mode (its commander's `HealthAndArmingChecks`)."""

from dataclasses import dataclass

from sitl.firmware.interface import Mode

PILOTED = frozenset((Mode.ALTCTL, Mode.STABILIZE))
WITHOUT_POSITION = PILOTED | {Mode.LAND}
"""Modes that may be flown without a position; LAND is the level descent then."""
MODES_TO_ARM_IN = frozenset((Mode.POSCTL, Mode.HOLD, Mode.TAKEOFF, Mode.MISSION, Mode.OFFBOARD))


@dataclass(frozen=True, slots=True)
class Situation:
    """What the checks look at.

    Attributes:
        mission_refusal: why the mission cannot be flown; None when it can.
    """

    armed: bool
    terminated: bool
    piloted: bool
    ground_missed: bool
    offboard_alive: bool
    position_ok: bool
    battery_low: bool
    mission_refusal: str | None


def reason_not_to_enter(mode: Mode, now: Situation) -> str | None:
    """Why a mode cannot be chosen now; None when it can."""
    if mode in PILOTED and not now.piloted:
        return "no manual control"
    if mode is Mode.OFFBOARD and now.armed and not now.offboard_alive:
        return "no offboard setpoints"
    if now.armed and not now.position_ok and mode not in WITHOUT_POSITION:
        return "no position"
    return now.mission_refusal if mode is Mode.MISSION else None


def reason_not_to_arm(mode: Mode, now: Situation) -> str | None:
    """Why a vehicle in this mode cannot be armed now; None when it can."""
    if now.terminated:
        return "flight termination active"
    if now.ground_missed:
        return "no connection to the ground control station"
    if not now.position_ok:
        return "Resolve system health failures first"
    if now.battery_low:
        return "low battery"
    if mode not in MODES_TO_ARM_IN:
        return f"mode {mode.name} is not suitable for takeoff"
    if mode is Mode.OFFBOARD and not now.offboard_alive:
        return "no offboard setpoints"
    return None
