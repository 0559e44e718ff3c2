"""Plans to a vehicle and from it; what was uploaded is read back and compared."""

import asyncio
from collections.abc import Callable, Sequence
from typing import TypeAlias

from companion.errors import FlightError, LinkError, NoReplyError, RefusedError
from companion.geodesy import Place
from companion.link.command import request_message
from companion.link.connection import Connection
from companion.link.dialect import mavlink
from companion.link.mission import WireItem, clear_items, download_items, upload_items
from companion.mission import wire
from companion.mission.items import Fence, Plan

ShowTransfer: TypeAlias = Callable[[str, int, int], None]
"""Called with what is done (as in "uploading mission"), how many items of it are, and how many there are."""

_MISSION = mavlink.MAV_MISSION_TYPE_MISSION
_FENCE = mavlink.MAV_MISSION_TYPE_FENCE
_RALLY = mavlink.MAV_MISSION_TYPE_RALLY
_KINDS = {_MISSION: "mission", _FENCE: "fence", _RALLY: "rally points"}
_HOME_UNIT_M = 1e-3
_DEGREE_UNIT = 1e-7


async def upload_plan(
    connection: Connection,
    plan: Plan,
    progress: ShowTransfer = lambda what, done, total: None,
    announce: Callable[[str], None] = lambda text: None,
) -> None:
    """Upload a plan: its mission, and its fence and rally points if it has any; then read them back.

    PX4 takes a plan whole or not at all. ArduPilot replaces its mission item by item, so the one that it has
    is read first, and uploaded again if the new one fails, or its upload is cancelled.

    Args:
        connection: to the vehicle.
        plan: what it is to have.
        progress: told how far that is.
        announce: told what the vehicle has when it was cancelled half-way.

    Raises:
        InputError: an item needs a place that neither the plan nor the vehicle knows.
        RefusedError: the vehicle refused; the message names the item, and has what the vehicle said.
        NoReplyError: it stopped answering.
        FlightError: it keeps something else than it was sent.
    """
    dialect = _dialect(connection)
    home = await vehicle_home(connection)
    mission = wire.mission_to_wire(plan.mission, home or plan.home, dialect)
    if plan.fence:
        await _replace(connection, _FENCE, wire.fence_to_wire(plan.fence), progress, announce)
    if plan.rally:
        await _replace(connection, _RALLY, wire.rally_to_wire(plan.rally), progress, announce)
    await _replace(connection, _MISSION, mission, progress, announce)


async def download_plan(
    connection: Connection, progress: ShowTransfer = lambda what, done, total: None
) -> Plan:
    """The plan that the vehicle has, and its home.

    Raises:
        RefusedError, NoReplyError, LinkError: as `download_items`.
        FlightError: it sent something that is no plan.
    """
    mission = await download_items(connection, _MISSION, _shown("downloading", _MISSION, progress))
    fence = await _download_if_there(connection, _FENCE, progress)
    rally = await _download_if_there(connection, _RALLY, progress)
    return Plan(
        mission=wire.mission_from_wire(mission, _dialect(connection)),
        fence=wire.fence_from_wire(fence),
        rally=wire.rally_from_wire(rally),
        home=await vehicle_home(connection),
        firmware=connection.heartbeat.autopilot,
    )


async def download_fence(connection: Connection) -> Fence:
    """The fence that the vehicle has; raises as `download_plan`."""
    return wire.fence_from_wire(await _download_if_there(connection, _FENCE, lambda what, done, total: None))


async def clear_plan(connection: Connection) -> None:
    """Delete the vehicle's mission, fence and rally points; raises as `clear_items`."""
    for kind in _KINDS:
        await clear_items(connection, kind)


async def vehicle_home(connection: Connection) -> Place | None:
    """Where the vehicle returns to; None while it does not tell."""
    try:
        home = await request_message(connection, mavlink.MAVLink_home_position_message, attempts=2)
    except NoReplyError:
        return None
    return Place(home.latitude * _DEGREE_UNIT, home.longitude * _DEGREE_UNIT, home.altitude * _HOME_UNIT_M)


def _dialect(connection: Connection) -> wire.Dialect:
    is_ardupilot = connection.heartbeat.autopilot == mavlink.MAV_AUTOPILOT_ARDUPILOTMEGA
    return wire.ARDUPILOT if is_ardupilot else wire.PX4


async def _replace(
    connection: Connection,
    kind: int,
    items: Sequence[WireItem],
    progress: ShowTransfer,
    announce: Callable[[str], None],
) -> None:
    """Upload one kind of plan and read it back; the former one stays, or comes back, where that fails."""
    is_atomic = connection.heartbeat.autopilot == mavlink.MAV_AUTOPILOT_PX4
    former = None if is_atomic else await download_items(connection, kind)
    try:
        await upload_items(connection, kind, items, _shown("uploading", kind, progress))
    except asyncio.CancelledError:
        announce(f"stopped half-way: {await _restored(connection, kind, former)}")
        raise
    except (LinkError, RefusedError) as error:
        raise type(error)(f"{error}; {await _restored(connection, kind, former)}") from error
    kept = await download_items(connection, kind, _shown("reading back", kind, progress))
    is_mission = kind == _MISSION
    otherwise = wire.difference(items, kept, first=int(is_mission and _dialect(connection).home_first))
    if otherwise is not None:
        raise FlightError(f"{_KINDS[kind]}: uploaded, but {otherwise}")


async def _restored(connection: Connection, kind: int, former: Sequence[WireItem] | None) -> str:
    """Upload what the vehicle had, unless it has it still (None); what it has now, in words."""
    if former is None:
        return f"the vehicle keeps its former {_KINDS[kind]}"
    try:
        await upload_items(connection, kind, former)
    except FlightError:
        return f"it may be left with a part of the new {_KINDS[kind]}: upload one again before it flies"
    return f"its former {_KINDS[kind]} was uploaded again"


async def _download_if_there(
    connection: Connection, kind: int, progress: ShowTransfer
) -> tuple[WireItem, ...]:
    """What the vehicle has of a kind that it need not know."""
    try:
        return await download_items(connection, kind, _shown("downloading", kind, progress))
    except RefusedError:
        return ()


def _shown(doing: str, kind: int, progress: ShowTransfer) -> Callable[[int, int], None]:
    return lambda done, total: progress(f"{doing} {_KINDS[kind]}", done, total)
