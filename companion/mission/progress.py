"""How far a vehicle is in its mission: items as they are reached, until it is done or somebody else flies."""

import asyncio
from collections import deque
from collections.abc import AsyncIterator, Awaitable, Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass
from functools import partial
from typing import NamedTuple, TypeAlias

from companion import clock
from companion.autopilot import Autopilot
from companion.errors import FlightError, LinkError, RefusedError, TakenError
from companion.link.command import command, set_message_interval
from companion.link.connection import Connection
from companion.link.dialect import mavlink
from companion.link.status import Landed, VehicleStatus
from companion.link.telemetry import Telemetry
from companion.mission.items import MissionItem

Announce: TypeAlias = Callable[[str], None]

_POLL_S = 0.05
_READY_WITHIN_S = 60.0
"""How long a vehicle that was just switched on may take until it can be armed."""
_CHECKED_WITHIN_S = 3.0
"""How long PX4 may take to look whether a mission that was just uploaded can be flown."""
_ASK_AGAIN_S = 1.0
_STARTS_WITHIN_S = 5.0
_ARRIVES_WITHIN_S = 1.5
"""A mode may be told this much before the item whose end it shows."""
_ARDUPILOT = mavlink.MAV_AUTOPILOT_ARDUPILOTMEGA
_ON_GROUND = (mavlink.MAV_CMD_NAV_LAND, mavlink.MAV_CMD_NAV_RETURN_TO_LAUNCH, mavlink.MAV_CMD_NAV_VTOL_LAND)
_LAST_NAVIGATION = mavlink.MAV_CMD_NAV_LAST
_CURRENT_HZ = 5.0


class _Modes(NamedTuple):
    """HEARTBEAT.custom_mode in a mission, on the way back, and holding."""

    mission: int
    back: int
    hold: int


_PX4_MODES = _Modes(mission=4 << 16 | 4 << 24, back=4 << 16 | 5 << 24, hold=4 << 16 | 3 << 24)
_ARDUPILOT_MODES = _Modes(mission=3, back=6, hold=5)


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
        await _repeatedly(autopilot.arm, _READY_WITHIN_S, announce)
    connection.send(mavlink.MAVLink_mission_set_current_message(*connection.target, _first_item(connection)))
    await _repeatedly(
        partial(command, connection, mavlink.MAV_CMD_MISSION_START), _CHECKED_WITHIN_S, announce
    )
    mode = _modes(connection).mission
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

    A mission that ends with a landing or a return is done when the vehicle is on the ground and disarmed, or
    stays there armed; another when its last navigation command is reached. Whoever stops iterating leaves the
    vehicle to its mission.

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
    watch, modes = _Watch(connection), _modes(connection)
    try:
        await start_mission(connection, telemetry, autopilot, announce)
        watch.on_mission_s = clock.now()
        while True:
            while watch.reached:
                index = watch.reached.popleft()
                if index < len(mission):
                    yield Reached(index, mission[index], len(mission))
            status = telemetry.status
            if _is_done(watch, status, status.custom_mode == modes.hold, mission):
                return
            if connection.lost:
                raise LinkError("the vehicle fell silent: check the link")
            if _is_own(watch, status, modes, mission):
                watch.on_mission_s = clock.now()
            elif clock.now() >= watch.on_mission_s + _ARRIVES_WITHIN_S:
                raise _interruption(watch, status.armed, autopilot.mode, len(mission))
            await asyncio.sleep(_POLL_S)
    finally:
        watch.end()


def _modes(connection: Connection) -> _Modes:
    return _ARDUPILOT_MODES if connection.heartbeat.autopilot == _ARDUPILOT else _PX4_MODES


def _first_item(connection: Connection) -> int:
    """The vehicle's number of a mission's first item: ArduPilot has home before it."""
    return int(connection.heartbeat.autopilot == _ARDUPILOT)


async def _repeatedly(ask: Callable[[], Awaitable[None]], within_s: float, announce: Announce) -> None:
    """Ask again while the vehicle refuses, for up to `within_s` (s); its last refusal is raised."""
    give_up_s = clock.now() + within_s
    told = ""
    while True:
        try:
            return await ask()
        except RefusedError as refusal:
            if clock.now() >= give_up_s:
                raise
            if str(refusal) != told:
                told = str(refusal)
                announce(f"not ready, trying for up to {within_s:g} s: {told}")
        await asyncio.sleep(_ASK_AGAIN_S)


class _Watch:
    """What the vehicle says of its mission.

    Attributes:
        reached: items reached that nobody has looked at yet, each once.
        newest: the last that was reached; -1 before any.
        current: where it is going; -1 until it says, and when ArduPilot is done.
        farthest: the greatest `current` so far.
        is_complete: whether it says that the mission is.
        on_mission_s: when it was last in the mode for missions (companion clock, s).
    """

    def __init__(self, connection: Connection) -> None:
        self.reached: deque[int] = deque()
        self.newest = self.current = -1
        self.is_complete = False
        self.on_mission_s = clock.now()
        self.farthest = -1
        self._first = _first_item(connection)
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
        if index != self.newest and 0 <= index <= self.farthest:
            self.newest = index
            self.reached.append(index)

    def _on_current(self, message: mavlink.MAVLink_mission_current_message) -> None:
        self.current = message.seq - self._first
        self.farthest = max(self.farthest, self.current)
        self.is_complete = message.mission_state == mavlink.MISSION_STATE_COMPLETE


def _is_done(watch: _Watch, status: VehicleStatus, holds: bool, mission: Sequence[MissionItem]) -> bool:
    """Whether the mission is over; `holds` tells that the vehicle is in its mode for that."""
    last = _last_navigation(mission)
    if mission[last].command in _ON_GROUND:
        return status.is_down(clock.now()) and watch.farthest >= last
    if watch.is_complete and watch.farthest >= last:
        return True
    goes_back = any(item.command == mavlink.MAV_CMD_DO_JUMP for item in mission[last:])
    return watch.newest >= last and (holds or not goes_back)


def _is_own(watch: _Watch, status: VehicleStatus, modes: _Modes, mission: Sequence[MissionItem]) -> bool:
    """Whether the vehicle is where its mission put it: PX4 has modes of their own for how one ends."""
    if not status.armed:
        return False
    last = _last_navigation(mission)
    is_over = watch.newest >= last or (watch.farthest >= last and status.landed is Landed.ON_GROUND)
    returns = (
        watch.current in range(len(mission))
        and mission[watch.current].command == mavlink.MAV_CMD_NAV_RETURN_TO_LAUNCH
    )
    mode = status.custom_mode
    return mode == modes.mission or (returns and mode == modes.back) or (is_over and mode == modes.hold)


def _interruption(watch: _Watch, armed: bool, mode: str, total: int) -> FlightError:
    """What to raise when the mission ended before it was done."""
    where = f"at item {max(watch.current, 0) + 1} of {total}"
    if not armed:
        return FlightError(f"the vehicle disarmed {where}, before its mission was done")
    return TakenError(f"the vehicle went to {mode} unasked, {where}: it was left to whoever did that")


def _last_navigation(mission: Sequence[MissionItem]) -> int:
    """Index of the last navigation command; of the last command where there is none."""
    indices = [index for index, item in enumerate(mission) if item.command <= _LAST_NAVIGATION]
    return indices[-1] if indices else len(mission) - 1
