"""What a vehicle tells of itself, kept as it comes."""

import math
from dataclasses import replace
from typing import Any

from companion.doctor.observation import Health
from companion.link.connection import Connection
from companion.link.dialect import mavlink
from companion.link.estimator import of_ardupilot, of_px4

_PREARM = mavlink.MAV_SYS_STATUS_PREARM_CHECK
_RC = mavlink.MAV_SYS_STATUS_SENSOR_RC_RECEIVER


class HealthWatch:
    """Keeps the newest of what a connection's vehicle tells of itself, in `health`."""

    def __init__(self, connection: Connection) -> None:
        self.health = Health()
        connection.subscribe(mavlink.MAVLink_estimator_status_message, self._on_estimator)
        connection.subscribe(mavlink.MAVLink_ekf_status_report_message, self._on_ekf)
        connection.subscribe(mavlink.MAVLink_sys_status_message, self._on_system)
        connection.subscribe(mavlink.MAVLink_battery_status_message, self._on_battery)
        connection.subscribe(mavlink.MAVLink_local_position_ned_message, self._on_position)
        connection.subscribe(mavlink.MAVLink_home_position_message, self._on_home)
        connection.subscribe(mavlink.MAVLink_gps_raw_int_message, self._on_gps)

    def _on_estimator(self, message: mavlink.MAVLink_estimator_status_message) -> None:
        self._update(estimator=of_px4(message))

    def _on_ekf(self, message: mavlink.MAVLink_ekf_status_report_message) -> None:
        self._update(estimator=of_ardupilot(message))

    def _on_system(self, message: mavlink.MAVLink_sys_status_message) -> None:
        healthy = message.onboard_control_sensors_health
        self._update(
            ready_to_arm=bool(healthy & _PREARM),  # PX4 sets this bit here alone, not in what is present
            has_remote_control=receives_remote_control(message),
        )
        self._take_charge(message.battery_remaining)

    def _on_battery(self, message: mavlink.MAVLink_battery_status_message) -> None:
        if message.id == 0:
            self._take_charge(message.battery_remaining)

    def _take_charge(self, percent: int) -> None:
        if percent >= 0:
            self._update(battery=percent / 100.0)

    def _on_position(self, message: mavlink.MAVLink_local_position_ned_message) -> None:
        self._update(has_position=math.isfinite(message.x + message.y + message.z))

    def _on_home(self, message: mavlink.MAVLink_home_position_message) -> None:
        self._update(has_home=True)

    def _on_gps(self, message: mavlink.MAVLink_gps_raw_int_message) -> None:
        self._update(gps_fix=message.fix_type, satellites=message.satellites_visible)

    def _update(self, **told: Any) -> None:
        self.health = replace(self.health, **told)


def receives_remote_control(message: mavlink.MAVLink_sys_status_message) -> bool:
    """Whether the vehicle has a remote control's receiver, and hears it."""
    return bool(message.onboard_control_sensors_health & message.onboard_control_sensors_present & _RC)


def missing_for_flight(health: Health) -> list[str]:
    """What a flight needs and is not there yet, in words."""
    missing: list[str] = []
    if health.estimator is not None and health.estimator.missing:
        missing.append(f"the estimator's {', '.join(health.estimator.missing)}")
    elif not health.has_position:
        missing.append("a position")
    if not health.ready_to_arm:
        missing.append("the checks before arming")
    return missing
