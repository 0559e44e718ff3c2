"""ArduPilot Copter's own names of the modes that it has here."""

from collections.abc import Mapping

from sitl.firmware.interface import Mode

MODE_NAMES: Mapping[Mode, str] = {
    Mode.STABILIZE: "STABILIZE",
    Mode.HOLD: "LOITER",
    Mode.BRAKE: "BRAKE",
    Mode.OFFBOARD: "GUIDED",
    Mode.LAND: "LAND",
    Mode.RTL: "RTL",
    Mode.MISSION: "AUTO",
}
