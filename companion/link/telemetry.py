"""The vehicle's state as its telemetry tells it, each with the time at which it held."""

import asyncio
import math
from collections import deque
from collections.abc import Callable
from typing import TypeAlias

import numpy as np

from companion import clock
from companion.errors import LinkError
from companion.link.connection import Connection
from companion.link.dialect import mavlink
from companion.link.message_rates import MessageRates
from companion.link.status import StatusWatch, VehicleStatus
from companion.link.timesync import REBOOT_S, ClockOffset
from companion.state import VehicleState

StateHandler: TypeAlias = Callable[[VehicleState], None]

_RATES_HZ = {
    mavlink.MAVLINK_MSG_ID_LOCAL_POSITION_NED: 100.0,
    mavlink.MAVLINK_MSG_ID_ATTITUDE: 100.0,
    mavlink.MAVLINK_MSG_ID_EXTENDED_SYS_STATE: 5.0,
    mavlink.MAVLINK_MSG_ID_HOME_POSITION: 0.5,
    mavlink.MAVLINK_MSG_ID_SYS_STATUS: 2.0,
    mavlink.MAVLINK_MSG_ID_GPS_RAW_INT: 5.0,
    mavlink.MAVLINK_MSG_ID_GLOBAL_POSITION_INT: 5.0,
    mavlink.MAVLINK_MSG_ID_POSITION_TARGET_LOCAL_NED: 17.0,  # in step with no other program's setpoints
}
_AT_TIMES = {mavlink.MAVLINK_MSG_ID_POSITION_TARGET_LOCAL_NED}
"""Messages that come while the vehicle follows setpoints."""
_OWN_RATES_HZ = {
    mavlink.MAV_AUTOPILOT_PX4: {
        mavlink.MAVLINK_MSG_ID_CURRENT_MODE: 10.0,
        mavlink.MAVLINK_MSG_ID_ESTIMATOR_STATUS: 2.0,
    },
    mavlink.MAV_AUTOPILOT_ARDUPILOTMEGA: {
        mavlink.MAVLINK_MSG_ID_HEARTBEAT: 5.0,
        mavlink.MAVLINK_MSG_ID_GPS_GLOBAL_ORIGIN: 0.5,
        mavlink.MAVLINK_MSG_ID_EKF_STATUS_REPORT: 2.0,
    },
}
"""Of one autopilot or the other. A change of mode must not wait for a heartbeat a second: PX4 sends these at
no other rate, and ArduPilot has no CURRENT_MODE. Its origin tells where its home is (`status`)."""
_TIMESYNC_INTERVAL_S = 0.1
_QUESTIONS_KEPT = 64
_ATTITUDES_KEPT = 5
_FARTHEST_ATTITUDE_MS = 100
_MOVES_M_S = 0.05


async def start_telemetry(connection: Connection) -> "Telemetry":
    """The telemetry of the connection's vehicle, asked for at 100 Hz, and again whenever it restarts.

    A vehicle that refuses a rate sends at its own, and that is what is used.

    Raises:
        NoReplyError: the vehicle answers no commands.
    """
    telemetry = Telemetry(connection)
    connection.spawn(telemetry.keep_time())
    await telemetry.rates.ask()
    connection.spawn(telemetry.rates.keep())
    return telemetry


class Telemetry:
    """The newest state and status of a vehicle; made by `start_telemetry`.

    A state is made of each LOCAL_POSITION_NED and the ATTITUDE nearest to it in time.

    Attributes:
        rates: what is asked of the vehicle.
        state: the newest, None until there is one.
        restarts: how often the vehicle's time fell back.
        out_of_order: how many positions came after newer ones, and were dropped.
        repeated: how many positions stood still while telling of a speed, and were dropped as frozen.
        not_finite: how many messages had numbers that were not finite, and were dropped.
    """

    def __init__(self, connection: Connection) -> None:
        own_hz = _OWN_RATES_HZ.get(connection.heartbeat.autopilot, {})
        self.rates = MessageRates(connection, _RATES_HZ | own_hz, _AT_TIMES)
        self.state: VehicleState | None = None
        self.restarts = 0
        self.out_of_order = 0
        self.repeated = 0
        self.not_finite = 0
        self._connection = connection
        self._watch = StatusWatch(connection)
        self._offset = ClockOffset()
        self._newest_s = -math.inf
        self._newest_position = np.full(3, math.nan)
        self._attitudes: deque[mavlink.MAVLink_attitude_message] = deque(maxlen=_ATTITUDES_KEPT)
        self._questions_ns: deque[int] = deque(maxlen=_QUESTIONS_KEPT)
        self._handlers: tuple[StateHandler, ...] = ()
        connection.subscribe(mavlink.MAVLink_timesync_message, self._on_timesync)
        connection.subscribe(mavlink.MAVLink_attitude_message, self._on_attitude)
        connection.subscribe(mavlink.MAVLink_local_position_ned_message, self._on_position)

    @property
    def status(self) -> VehicleStatus:
        """What the vehicle is doing."""
        return self._watch.status

    def subscribe(self, handler: StateHandler) -> Callable[[], None]:
        """Call `handler` with each new state, in order of time; returns what ends that."""
        self._handlers += (handler,)

        def unsubscribe() -> None:
            self._handlers = tuple(other for other in self._handlers if other is not handler)

        return unsubscribe

    async def next_state(self, timeout_s: float = 2.0) -> VehicleState:
        """The next state to come.

        Raises:
            LinkError: none came within `timeout_s` (s).
        """
        arrived: asyncio.Future[VehicleState] = asyncio.get_running_loop().create_future()
        unsubscribe = self.subscribe(lambda state: None if arrived.done() else arrived.set_result(state))
        try:
            async with asyncio.timeout(timeout_s):
                return await arrived
        except TimeoutError:
            raise LinkError(
                f"no position and attitude from the vehicle within {timeout_s:g} s: "
                "check that its estimator is ready and that the link carries both"
            ) from None
        finally:
            unsubscribe()

    async def keep_time(self) -> None:
        """Ask the vehicle for its time, again and again."""
        while True:
            asked_ns = _nanoseconds(clock.now())
            self._questions_ns.append(asked_ns)
            self._connection.send(mavlink.MAVLink_timesync_message(tc1=0, ts1=asked_ns))
            await asyncio.sleep(_TIMESYNC_INTERVAL_S)

    def _on_timesync(self, message: mavlink.MAVLink_timesync_message) -> None:
        now_s = clock.now()
        if message.tc1 == 0:
            self._connection.send(mavlink.MAVLink_timesync_message(tc1=_nanoseconds(now_s), ts1=message.ts1))
        elif message.ts1 in self._questions_ns:  # the answer to us, not to another peer
            self._questions_ns.remove(message.ts1)
            self._offset.round_trip(message.ts1 * 1e-9, message.tc1 * 1e-9, now_s)

    def _on_attitude(self, message: mavlink.MAVLink_attitude_message) -> None:
        angles = message.roll + message.pitch + message.yaw
        rates = message.rollspeed + message.pitchspeed + message.yawspeed
        if math.isfinite(angles + rates):
            self._attitudes.append(message)
        else:
            self.not_finite += 1

    def _on_position(self, message: mavlink.MAVLink_local_position_ned_message) -> None:
        vehicle_s = message.time_boot_ms * 1e-3
        if self._newest_s - REBOOT_S <= vehicle_s <= self._newest_s:
            self.out_of_order += 1
            return
        if not math.isfinite(message.x + message.y + message.z + message.vx + message.vy + message.vz):
            self.not_finite += 1
            return
        if vehicle_s < self._newest_s:
            self.restarts += 1
            self.rates.ask_again()
        self._newest_s = vehicle_s
        position = np.array([message.x, message.y, message.z])
        velocity = np.array([message.vx, message.vy, message.vz])
        if np.array_equal(position, self._newest_position) and math.hypot(*velocity) > _MOVES_M_S:
            self.repeated += 1
            return
        self._newest_position = position
        received_s = clock.now()
        time_s = self._offset.companion_time(vehicle_s, received_s)
        attitude = self._attitude_at(message.time_boot_ms)
        if attitude is None:
            return
        state = VehicleState(
            time_s=time_s,
            received_s=received_s,
            position=position,
            velocity=velocity,
            attitude=np.array([attitude.roll, attitude.pitch, attitude.yaw]),
            rates=np.array([attitude.rollspeed, attitude.pitchspeed, attitude.yawspeed]),
        )
        self.state = state
        for handler in self._handlers:
            handler(state)

    def _attitude_at(self, time_ms: int) -> mavlink.MAVLink_attitude_message | None:
        """The attitude nearest to `time_ms` (vehicle clock); None if none is near enough."""
        nearest = min(self._attitudes, key=lambda other: abs(other.time_boot_ms - time_ms), default=None)
        if nearest is None or abs(nearest.time_boot_ms - time_ms) > _FARTHEST_ATTITUDE_MS:
            return None
        return nearest


def _nanoseconds(time_s: float) -> int:
    return round(time_s * 1e9)
