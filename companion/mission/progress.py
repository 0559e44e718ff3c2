"""How far a vehicle is in its mission: items as they are reached, until it is done or somebody else flies."""

import asyncio
from collections import deque
from collections.abc import AsyncIterator, Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass
from typing import TypeAlias

from companion import clock
from companion.autopilot import Autopilot
from companion.errors import FlightError, LinkError, RefusedError, TakenError
from companion.link.command import command, set_message_interval
from companion.link.connection import Connection
from companion.link.dialect import mavlink
from companion.link.status import Landed
from companion.link.telemetry import Telemetry
from companion.mission.items import MissionItem

Announce: TypeAlias = Callable[[str], None]

_POLL_S = 0.05
_READY_WITHIN_S = 60.0
"""How long a vehicle that was just switched on may take until it can be armed."""
_ASK_AGAIN_S = 1.0
_STARTS_WITHIN_S = 5.0
_ARRIVES_WITHIN_S = 1.5
"""A mode may be told this much before the item whose end it shows."""
_PX4, _ARDUPILOT = mavlink.MAV_AUTOPILOT_PX4, mavlink.MAV_AUTOPILOT_ARDUPILOTMEGA
_MISSION_MODES = {_PX4: 4 << 16 | 4 << 24, _ARDUPILOT: 3}
"""HEARTBEAT.custom_mode while a mission is flown: AUTO.MISSION and AUTO."""
_RETURN_MODES = {_PX4: 4 << 16 | 5 << 24, _ARDUPILOT: 6}
_ON_GROUND = (mavlink.MAV_CMD_NAV_LAND, mavlink.MAV_CMD_NAV_RETURN_TO_LAUNCH, mavlink.MAV_CMD_NAV_VTOL_LAND)
_LAST_NAVIGATION = mavlink.MAV_CMD_NAV_LAST
_CURRENT_HZ = 5.0


@dataclass(frozen=True, slots=True)
class Reached:
    """An item that the vehicle has reached.

    Attributes:
        index: of the item in the mission, from 0.
        item: what it is.
        total: how many items the mission has.
    """

    index: int
    item: MissionItem
    total: int


async def start_mission(
    connection: Connection, telemetry: Telemetry, autopilot: Autopilot, announce: Announce = lambda text: None
) -> None:
    """Have the vehicle fly its mission from the first item on; arms it, as soon as it is ready, if need be.

    Raises:
        RefusedError, NoReplyError: it refused, or did not answer.
        FlightError: it accepted, but does not fly the mission.
    """
    if not telemetry.status.armed:
        await _arm_when_ready(autopilot, announce)
    await command(connection, mavlink.MAV_CMD_MISSION_START)
    mode = _MISSION_MODES.get(connection.heartbeat.autopilot)
    give_up_s = clock.now() + _STARTS_WITHIN_S
    while telemetry.status.custom_mode != mode:
        if clock.now() >= give_up_s:
            raise FlightError(
                f"the vehicle accepted, but does not fly its mission within {_STARTS_WITHIN_S:g} s; "
                f"mode {autopilot.mode}"
            )
        await asyncio.sleep(_POLL_S)


async def fly_mission(
    connection: Connection,
    telemetry: Telemetry,
    autopilot: Autopilot,
    mission: Sequence[MissionItem],
    announce: Announce = lambda text: None,
) -> AsyncIterator[Reached]:
    """Start the mission that the vehicle has, and tell each item as it is reached, until it is done.

    A mission that ends with a landing or a return is done when the vehicle is on the ground and disarmed;
    another when its last navigation command is reached. Whoever stops iterating leaves the vehicle to its
    mission.

    Args:
        connection: to the vehicle.
        telemetry: of the same vehicle.
        autopilot: of the same vehicle.
        mission: the one that it has.
        announce: told why the vehicle is not ready, if it is not.

    Raises:
        RefusedError, NoReplyError: as `start_mission`.
        TakenError: the vehicle went to another mode unasked; it is left to whoever did that.
        FlightError: it disarmed before the end.
        LinkError: it fell silent.
    """
    if not mission:
        raise FlightError("there is no mission to fly: upload one")
    with suppress(RefusedError):  # then it sends at its own rate
        await set_message_interval(connection, mavlink.MAVLINK_MSG_ID_MISSION_CURRENT, _CURRENT_HZ)
    watch = _Watch(connection)
    try:
        await start_mission(connection, telemetry, autopilot, announce)
        watch.on_mission_s = clock.now()
        while True:
            while watch.reached:
                index = watch.reached.popleft()
                if index < len(mission):
                    yield Reached(index, mission[index], len(mission))
            if _is_done(watch, telemetry, mission):
                return
            _require_on_mission(watch, connection, telemetry, autopilot, mission)
            await asyncio.sleep(_POLL_S)
    finally:
        watch.end()


async def _arm_when_ready(autopilot: Autopilot, announce: Announce) -> None:
    """Arm, asking again while the vehicle is still getting ready."""
    give_up_s = clock.now() + _READY_WITHIN_S
    told = ""
    while True:
        try:
            return await autopilot.arm()
        except RefusedError as refusal:
            if clock.now() >= give_up_s:
                raise
            if str(refusal) != told:
                told = str(refusal)
                announce(f"not ready, trying for up to {_READY_WITHIN_S:g} s: {told}")
        await asyncio.sleep(_ASK_AGAIN_S)


class _Watch:
    """What the vehicle says of its mission.

    Attributes:
        reached: items reached that nobody has looked at yet, each once.
        newest: the last that was reached; -1 before any.
        current: where it is going; -1 until it says.
        is_complete: whether it says that the mission is.
        on_mission_s: when it was last in the mode for missions (companion clock, s).
    """

    def __init__(self, connection: Connection) -> None:
        self.reached: deque[int] = deque()
        self.newest = self.current = -1
        self.is_complete = False
        self.on_mission_s = clock.now()
        self._farthest = -1
        self._first = int(connection.heartbeat.autopilot == _ARDUPILOT)  # item 0 of ArduPilot is home
        self._ends = (
            connection.subscribe(mavlink.MAVLink_mission_item_reached_message, self._on_reached),
            connection.subscribe(mavlink.MAVLink_mission_current_message, self._on_current),
        )

    def end(self) -> None:
        """Look no more."""
        for end in self._ends:
            end()

    def _on_reached(self, message: mavlink.MAVLink_mission_item_reached_message) -> None:
        """Note an item, once: PX4 says each several times, those of the flight before, too."""
        index = message.seq - self._first
        if index != self.newest and 0 <= index <= self._farthest:
            self.newest = index
            self.reached.append(index)

    def _on_current(self, message: mavlink.MAVLink_mission_current_message) -> None:
        self.current = message.seq - self._first
        self._farthest = max(self._farthest, self.current)
        self.is_complete = message.mission_state == mavlink.MISSION_STATE_COMPLETE


def _is_done(watch: _Watch, telemetry: Telemetry, mission: Sequence[MissionItem]) -> bool:
    last = _last_navigation(mission)
    if mission[last].command in _ON_GROUND:
        is_down = telemetry.status.landed is Landed.ON_GROUND and not telemetry.status.armed
        return is_down and max(watch.current, watch.newest) >= last
    return watch.newest >= last or (watch.is_complete and watch.current >= last)


def _require_on_mission(
    watch: _Watch,
    connection: Connection,
    telemetry: Telemetry,
    autopilot: Autopilot,
    mission: Sequence[MissionItem],
) -> None:
    """Raise unless the vehicle flies the mission, or came off it only just now."""
    if connection.lost:
        raise LinkError("the vehicle fell silent: check the link")
    firmware, mode = connection.heartbeat.autopilot, telemetry.status.custom_mode
    returns = (
        watch.current in range(len(mission))
        and mission[watch.current].command == mavlink.MAV_CMD_NAV_RETURN_TO_LAUNCH
    )
    own = {_MISSION_MODES.get(firmware), _RETURN_MODES.get(firmware) if returns else None}
    if telemetry.status.armed and mode in own:
        watch.on_mission_s = clock.now()
    elif clock.now() >= watch.on_mission_s + _ARRIVES_WITHIN_S:
        where = f"at item {max(watch.current, 0)} of {len(mission)}"
        if not telemetry.status.armed:
            raise FlightError(f"the vehicle disarmed {where}, before its mission was done")
        raise TakenError(
            f"the vehicle went to {autopilot.mode} unasked, {where}: it was left to whoever did that"
        )


def _last_navigation(mission: Sequence[MissionItem]) -> int:
    """Index of the last navigation command; of the last command where there is none."""
    indices = [index for index, item in enumerate(mission) if item.command <= _LAST_NAVIGATION]
    return indices[-1] if indices else len(mission) - 1
