"""What ArduPilot watches while armed: battery, radio and ground station (`AP_BattMonitor`, `events.cpp`)."""

from collections.abc import Iterator, Mapping

from sitl.firmware.ardupilot_parameters import ArduPilotParameters
from sitl.firmware.interface import Mode
from sitl.firmware.pilot import Pilot
from sitl.plant import TICK_S

_BATTERY_ACTIONS = {0: None, 1: Mode.LAND, 2: Mode.RTL}
_GROUND_LOST: Mapping[int, Mode] = {5: Mode.LAND, 7: Mode.BRAKE}
_RADIO_LOST: Mapping[int, Mode] = {3: Mode.LAND, 7: Mode.BRAKE}
"""FS_GCS_ENABLE and FS_THR_ENABLE; all others are RTL here."""
_GUIDED_WITHOUT_RADIO, _GO_ON_LANDING, _PILOTED_WITHOUT_GROUND = 1 << 2, 1 << 3, 1 << 4
"""Bits of FS_OPTIONS."""
_PILOTED = (Mode.STABILIZE, Mode.HOLD)


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


class Links:
    """Whether radio and ground station, once heard, have fallen silent, and what follows."""

    def __init__(self) -> None:
        self._ground_heard_s: float | None = None
        self._radio_lost = False

    def hear_ground(self, parameters: ArduPilotParameters, system_id: int, time_s: float) -> None:
        """A ground station has spoken; that of SYSID_MYGCS counts."""
        if system_id == parameters.SYSID_MYGCS:
            self._ground_heard_s = time_s

    def lost(
        self, parameters: ArduPilotParameters, mode: Mode, pilot: Pilot, time_s: float
    ) -> Iterator[tuple[str, Mode]]:
        """What has just been missed for too long, and the mode to go on in."""
        p, heard_s = parameters, self._ground_heard_s
        goes_on = mode is Mode.LAND and p.FS_OPTIONS & _GO_ON_LANDING
        if p.FS_GCS_ENABLE and heard_s is not None and time_s - heard_s > p.FS_GCS_TIMEOUT:
            self._ground_heard_s = None
            piloted = mode in _PILOTED and p.FS_OPTIONS & _PILOTED_WITHOUT_GROUND
            yield "GCS", mode if goes_on or piloted else _GROUND_LOST.get(p.FS_GCS_ENABLE, Mode.RTL)
        was_lost, self._radio_lost = self._radio_lost, pilot.is_lost(0.0, p.RC_FS_TIMEOUT, time_s)
        if p.FS_THR_ENABLE and self._radio_lost and not was_lost:
            guided = mode is Mode.OFFBOARD and p.FS_OPTIONS & _GUIDED_WITHOUT_RADIO
            yield "Radio", mode if goes_on or guided else _RADIO_LOST.get(p.FS_THR_ENABLE, Mode.RTL)
