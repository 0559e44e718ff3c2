"""Scripted autopilots with the habits that recordings of PX4 1.16 and ArduPilot Copter 4.7 show."""

import asyncio
from collections.abc import Iterable
from typing import Any

from fake_autopilots import GUIDED, LAND, LOITER, FakeArduPilot, FakePx4, accepted, refused

from companion.link.dialect import Message, mavlink

ARM, TAKEOFF, LANDING = (
    mavlink.MAV_CMD_COMPONENT_ARM_DISARM,
    mavlink.MAV_CMD_NAV_TAKEOFF,
    mavlink.MAV_CMD_NAV_LAND,
)
TAKING_OFF, AUTO_LAND = 4 << 16 | 2 << 24, 4 << 16 | 6 << 24
_DISARMS_AFTER_S = 10.0
_ON_DEMAND = (
    mavlink.MAVLINK_MSG_ID_ATTITUDE,
    mavlink.MAVLINK_MSG_ID_LOCAL_POSITION_NED,
    mavlink.MAVLINK_MSG_ID_EXTENDED_SYS_STATE,
)


class RecordedPx4(FakePx4):
    """Answers a change of mode twice, climbs and lands in its time, moves its home, and is not alone.

    Heartbeats come once a second, CURRENT_MODE at a change and twice a second.
    """

    mode = LOITER

    def __init__(self) -> None:
        super().__init__()
        self.landed = mavlink.MAV_LANDED_STATE_ON_GROUND
        self.telemetry_hz = 50.0
        self.ready_at_s = 0.0
        self.takes_off_at_s = 0.0
        self.stops_below_m = 0.0
        self._told = self.mode
        self._encoders = [
            mavlink.MAVLink(None, srcSystem=1, srcComponent=mavlink.MAV_COMP_ID_GIMBAL),
            mavlink.MAVLink(None, srcSystem=255, srcComponent=190),
            mavlink.MAVLink(None, srcSystem=2, srcComponent=1),
        ]

    @property
    def now_s(self) -> float:
        return self._time_ms * 1e-3

    def _live(self) -> None:
        self._time_ms = round((self._loop.time() - self._born_s) * 1e3)
        at_s = self._time_ms
        self.say(mavlink.MAVLink_attitude_message(at_s, 0, 0, 0, 0, 0, 0))
        if self.knows_where_it_is:
            self.say(mavlink.MAVLink_local_position_ned_message(at_s, 0, 0, -self.altitude_m, 0, 0, 0))
        self.say(mavlink.MAVLink_extended_sys_state_message(0, self.landed))
        if self._told != self.mode:
            self._tell_mode()
        self._tell_place()
        self._loop.call_later(1.0 / self.telemetry_hz, self._live)

    def _beat(self) -> None:
        flags = mavlink.MAV_MODE_FLAG_SAFETY_ARMED if self.armed else 0
        self.say(mavlink.MAVLink_heartbeat_message(self.type, self.autopilot, flags, self.mode, 4, 3))
        moved_m = 0.01 * self.now_s
        self.say(mavlink.MAVLink_home_position_message(0, 0, 0, 0, 0, -moved_m, [1, 0, 0, 0], 0, 0, 0))
        others = (
            mavlink.MAVLink_heartbeat_message(mavlink.MAV_TYPE_GIMBAL, 8, 0, 0, 4, 3),
            mavlink.MAVLink_heartbeat_message(mavlink.MAV_TYPE_GCS, 8, 0, 0, 4, 3),
            mavlink.MAVLink_heartbeat_message(self.type, self.autopilot, 128, 0, 4, 3),
        )
        for encoder, message in zip(self._encoders, others, strict=True):
            self._transport.deliver(message.pack(encoder))
        self._loop.call_later(1.0, self._beat)

    def _tell_mode(self) -> None:
        self._told = self.mode
        self.say(mavlink.MAVLink_current_mode_message(0, self.mode, self.mode))

    async def _open(self, receiver: Any) -> Any:
        self._born_s = asyncio.get_running_loop().time()
        transport = await super()._open(receiver)
        self._beat()
        return transport

    def _obey(self, message: Any) -> Iterable[Message]:
        match message.command:
            case mavlink.MAV_CMD_COMPONENT_ARM_DISARM if self.now_s < self.ready_at_s:
                return refused(ARM, "Preflight Fail: ekf2 missing data")
            case mavlink.MAV_CMD_COMPONENT_ARM_DISARM:
                self.armed = True
                self._loop.call_later(_DISARMS_AFTER_S, self._disarm_on_the_ground)
            case mavlink.MAV_CMD_NAV_TAKEOFF if self.now_s < self.takes_off_at_s or not self.armed:
                return refused(TAKEOFF, "Takeoff denied!")
            case mavlink.MAV_CMD_NAV_TAKEOFF:
                self.mode = TAKING_OFF
                self._climb(message.param7 - 488.0 - self.stops_below_m)
            case mavlink.MAV_CMD_NAV_LAND:
                self.mode = AUTO_LAND
                self._loop.call_later(8.0, self._touch_down)
            case mavlink.MAV_CMD_DO_SET_MODE:
                return [*super()._obey(message), accepted(message.command)]
        return [accepted(message.command)]

    def _climb(self, to_m: float) -> None:
        self.altitude_m = min(to_m, self.altitude_m + 0.1)
        self.landed = mavlink.MAV_LANDED_STATE_IN_AIR
        if self.altitude_m < to_m:
            self._loop.call_later(0.1, self._climb, to_m)
        elif self.mode == TAKING_OFF:
            self.mode = LOITER

    def _touch_down(self) -> None:
        self.altitude_m, self.landed = 0.0, mavlink.MAV_LANDED_STATE_ON_GROUND
        self._loop.call_later(2.0, self._disarm_on_the_ground)

    def _disarm_on_the_ground(self) -> None:
        if self.landed == mavlink.MAV_LANDED_STATE_ON_GROUND:
            self.armed, self.mode = False, LOITER


class RecordedArduPilot(FakeArduPilot):
    """Sends only heartbeats until asked, and is ready only when its estimator has used GPS for a while.

    The estimator's position comes at 23 s; arming is refused until 35 s.
    """

    def __init__(self) -> None:
        super().__init__()
        self.streams: set[int] = set()

    @property
    def now_s(self) -> float:
        return self._time_ms * 1e-3

    def say(self, *messages: Message) -> None:
        super().say(*(each for each in messages if each.id not in _ON_DEMAND or each.id in self.streams))

    def _live(self) -> None:
        self.knows_where_it_is = self._time_ms > 23_000
        super()._live()

    def _obey(self, message: Any) -> Iterable[Message]:
        match message.command:
            case mavlink.MAV_CMD_SET_MESSAGE_INTERVAL:
                self.streams.add(int(message.param1))
            case mavlink.MAV_CMD_DO_SET_MODE if message.param2 == GUIDED and not self.knows_where_it_is:
                return refused(message.command, "Mode change to GUIDED failed: requires position")
            case mavlink.MAV_CMD_COMPONENT_ARM_DISARM if self.now_s < 35.0:
                return refused(ARM, "PreArm: Need Position Estimate")
            case mavlink.MAV_CMD_NAV_LAND:
                self.mode = LAND
                self._loop.call_later(8.0, self._touch_down)
            case _:
                return super()._obey(message)
        return [accepted(message.command)]

    def _touch_down(self) -> None:
        self.altitude_m, self.armed = 0.0, False
