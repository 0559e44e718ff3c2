"""The links of PX4 and ArduPilot and the streams that each carries by default; peers may change the rates."""

import heapq
from collections.abc import Mapping
from dataclasses import dataclass

from pymavlink.dialects.v20 import common as mavlink
from pymavlink.dialects.v20.development import MAVLink_current_mode_message

CURRENT_MODE: int = MAVLink_current_mode_message.id


@dataclass(frozen=True, eq=False)
class Link:
    """One of the vehicle's links.

    Attributes:
        name: for people.
        rates_hz: stream rates (Hz) by message id, until a peer asks for others.
    """

    name: str
    rates_hz: Mapping[int, float]


OFFBOARD = Link(
    "offboard",
    {
        mavlink.MAVLINK_MSG_ID_HEARTBEAT: 1.0,
        mavlink.MAVLINK_MSG_ID_TIMESYNC: 10.0,
        mavlink.MAVLINK_MSG_ID_ATTITUDE: 100.0,
        mavlink.MAVLINK_MSG_ID_ATTITUDE_QUATERNION: 50.0,
        mavlink.MAVLINK_MSG_ID_GLOBAL_POSITION_INT: 50.0,
        mavlink.MAVLINK_MSG_ID_LOCAL_POSITION_NED: 30.0,
        mavlink.MAVLINK_MSG_ID_ODOMETRY: 30.0,
        mavlink.MAVLINK_MSG_ID_ALTITUDE: 10.0,
        mavlink.MAVLINK_MSG_ID_POSITION_TARGET_LOCAL_NED: 10.0,
        mavlink.MAVLINK_MSG_ID_ATTITUDE_TARGET: 10.0,
        mavlink.MAVLINK_MSG_ID_SERVO_OUTPUT_RAW: 10.0,
        mavlink.MAVLINK_MSG_ID_VFR_HUD: 10.0,
        mavlink.MAVLINK_MSG_ID_GPS_RAW_INT: 10.0,
        mavlink.MAVLINK_MSG_ID_EXTENDED_SYS_STATE: 5.0,
        mavlink.MAVLINK_MSG_ID_SYS_STATUS: 5.0,
        mavlink.MAVLINK_MSG_ID_PING: 1.0,
        mavlink.MAVLINK_MSG_ID_MISSION_CURRENT: 1.0,
        mavlink.MAVLINK_MSG_ID_SYSTEM_TIME: 1.0,
        mavlink.MAVLINK_MSG_ID_ESTIMATOR_STATUS: 1.0,
        mavlink.MAVLINK_MSG_ID_GPS_GLOBAL_ORIGIN: 1.0,
        mavlink.MAVLINK_MSG_ID_HOME_POSITION: 0.5,
        mavlink.MAVLINK_MSG_ID_BATTERY_STATUS: 0.5,
        mavlink.MAVLINK_MSG_ID_VIBRATION: 0.5,
        CURRENT_MODE: 0.5,
    },
)
"""For companions: MAVLINK_MODE_ONBOARD in PX4's mavlink_main.cpp. GPS_RAW_INT is unlimited there, hence at
the receiver's own rate."""

GROUND_STATION = Link(
    "ground station",
    {
        mavlink.MAVLINK_MSG_ID_HEARTBEAT: 1.0,
        mavlink.MAVLINK_MSG_ID_ATTITUDE: 50.0,
        mavlink.MAVLINK_MSG_ID_ATTITUDE_QUATERNION: 50.0,
        mavlink.MAVLINK_MSG_ID_GLOBAL_POSITION_INT: 50.0,
        mavlink.MAVLINK_MSG_ID_LOCAL_POSITION_NED: 50.0,
        mavlink.MAVLINK_MSG_ID_POSITION_TARGET_LOCAL_NED: 50.0,
        mavlink.MAVLINK_MSG_ID_GPS_RAW_INT: 5.0,
        mavlink.MAVLINK_MSG_ID_VFR_HUD: 4.0,
        mavlink.MAVLINK_MSG_ID_ALTITUDE: 1.0,
        mavlink.MAVLINK_MSG_ID_EXTENDED_SYS_STATE: 1.0,
        mavlink.MAVLINK_MSG_ID_SYSTEM_TIME: 1.0,
        mavlink.MAVLINK_MSG_ID_ESTIMATOR_STATUS: 0.5,
        mavlink.MAVLINK_MSG_ID_VIBRATION: 0.1,
        mavlink.MAVLINK_MSG_ID_ATTITUDE_TARGET: 2.0,
        CURRENT_MODE: 0.5,
        mavlink.MAVLINK_MSG_ID_GPS_GLOBAL_ORIGIN: 1.0,
        mavlink.MAVLINK_MSG_ID_SYS_STATUS: 1.0,
        mavlink.MAVLINK_MSG_ID_HOME_POSITION: 0.5,
        mavlink.MAVLINK_MSG_ID_BATTERY_STATUS: 0.5,
        mavlink.MAVLINK_MSG_ID_PING: 0.1,
        mavlink.MAVLINK_MSG_ID_MISSION_CURRENT: 1.0,
    },
)
"""For ground stations: MAVLINK_MODE_NORMAL there, with what its simulator's px4-rc.mavlink adds."""

TELEMETRY = Link(
    "telemetry",
    {mavlink.MAVLINK_MSG_ID_HEARTBEAT: 1.0, mavlink.MAVLINK_MSG_ID_TIMESYNC: 0.1},
)
"""ArduPilot's telemetry in its simulator: silent but for this until a peer asks for more."""

SERIAL_0, SERIAL_1, SERIAL_2 = (Link(f"serial {number}", TELEMETRY.rates_hz) for number in range(3))
"""ArduPilot's serial ports, which its simulator offers over TCP."""


class Streams:
    """Which messages of one link are due when."""

    def __init__(self, rates_hz: Mapping[int, float]) -> None:
        self._default_us = {message_id: round(1e6 / rate_hz) for message_id, rate_hz in rates_hz.items()}
        self._interval_us = dict(self._default_us)
        self._due_us = [(0, message_id) for message_id in sorted(self._interval_us)]

    def take_due(self, now_us: int) -> list[int]:
        """The ids of the messages that are due at `now_us` (µs), each once; their next turn is set."""
        due = []
        while self._due_us and self._due_us[0][0] <= now_us:
            due_us, message_id = self._due_us[0]
            due.append(message_id)
            next_us = due_us + self._interval_us[message_id]
            if next_us <= now_us:  # asked for more often than the vehicle ticks: at each tick then
                next_us = now_us + 1
            heapq.heapreplace(self._due_us, (next_us, message_id))
        return due

    def interval_us(self, message_id: int) -> int | None:
        """The interval of a stream (µs); None when it is off."""
        return self._interval_us.get(message_id)

    def set_interval(self, message_id: int, interval_us: int, now_us: int) -> None:
        """Send a message every `interval_us` (µs) from now on: negative stops it, 0 is the link's default."""
        self._interval_us.pop(message_id, None)
        self._due_us = [entry for entry in self._due_us if entry[1] != message_id]
        heapq.heapify(self._due_us)
        if interval_us == 0:
            interval_us = self._default_us.get(message_id, -1)
        if interval_us > 0:
            self._interval_us[message_id] = interval_us
            heapq.heappush(self._due_us, (now_us, message_id))
