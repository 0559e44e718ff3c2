"""What ArduPilot watches while it is armed: battery and ground station (`AP_BattMonitor`, `events.cpp`)."""

from sitl.firmware.ardupilot_parameters import ArduPilotParameters
from sitl.firmware.interface import Mode
from sitl.plant import TICK_S

_BATTERY_ACTIONS = {0: None, 1: Mode.LAND, 2: Mode.RTL}
_LAND = 5
_GO_ON_IN_GUIDED = 1 << 2
"""Bit of FS_OPTIONS."""


class LowBattery:
    """Whether the voltage has been below BATT_LOW_VOLT for BATT_LOW_TIMER."""

    def __init__(self) -> None:
        self._low_s = 0.0

    def begins(self, parameters: ArduPilotParameters, voltage_v: float) -> bool:
        """Whether it has just been low for long enough."""
        before_s = self._low_s
        self._low_s = before_s + TICK_S if voltage_v < parameters.BATT_LOW_VOLT else 0.0
        return before_s < parameters.BATT_LOW_TIMER <= self._low_s

    def forbids_arming(self, parameters: ArduPilotParameters, voltage_v: float) -> bool:
        """Whether it is low, or was until now."""
        return self._low_s > 0.0 or voltage_v < parameters.BATT_LOW_VOLT

    @staticmethod
    def action(parameters: ArduPilotParameters) -> Mode | None:
        """What BATT_FS_LOW_ACT asks for."""
        return _BATTERY_ACTIONS[parameters.BATT_FS_LOW_ACT]


class GroundLink:
    """Whether the ground station of SYSID_MYGCS, once heard, has fallen silent."""

    def __init__(self) -> None:
        self._heard_s: float | None = None

    def hear(self, parameters: ArduPilotParameters, system_id: int, time_s: float) -> None:
        """A ground station has spoken."""
        if system_id == parameters.SYSID_MYGCS:
            self._heard_s = time_s

    def breaks(self, parameters: ArduPilotParameters, time_s: float) -> bool:
        """Whether it has just been silent for FS_GCS_TIMEOUT, and FS_GCS_ENABLE cares."""
        p, heard_s = parameters, self._heard_s
        if not p.FS_GCS_ENABLE or heard_s is None or time_s - heard_s <= p.FS_GCS_TIMEOUT:
            return False
        self._heard_s = None
        return True

    @staticmethod
    def action(parameters: ArduPilotParameters, mode: Mode) -> Mode | None:
        """What FS_GCS_ENABLE asks for in this mode; None to go on."""
        if mode is Mode.LAND or (mode is Mode.OFFBOARD and parameters.FS_OPTIONS & _GO_ON_IN_GUIDED):
            return None
        return Mode.LAND if parameters.FS_GCS_ENABLE == _LAND else Mode.RTL
