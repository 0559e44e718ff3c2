"""The vehicle's own fence, for the guard of a flight."""

from companion.autopilot.steps import parameter_or
from companion.errors import LinkError, NoReplyError
from companion.flight.fence import Areas
from companion.flight.guard import NO_AREAS
from companion.flight.takeoff import Announce
from companion.link.connection import Connection
from companion.link.dialect import mavlink
from companion.link.telemetry import Telemetry
from companion.mission.boundaries import areas_of
from companion.mission.site import vehicle_site
from companion.mission.transfer import download_fence

_ANY_INCLUSION = 1 << 1
"""FENCE_OPTIONS: allow union of inclusion areas."""


async def vehicle_fence(connection: Connection, telemetry: Telemetry, announce: Announce) -> Areas:
    """The fence that the vehicle has, north and east of its takeoff point; none where it tells none.

    Raises:
        LinkError: it has one, but does not come to know its position.
    """
    try:
        fence = await download_fence(connection)
    except LinkError:
        announce("the vehicle tells no fence: only the guard's is kept to")
        return NO_AREAS
    if not (fence.polygons or fence.circles):
        return NO_AREAS
    try:
        site = await vehicle_site(connection, telemetry)
    except NoReplyError as unknown:
        announce(f"the vehicle's fence cannot be placed ({unknown}): only the guard's is kept to")
        return NO_AREAS
    areas = areas_of(fence, site).model_copy(update={"in_all": await _counts_all(connection)})
    announce(f"the vehicle's own fence of {len(areas.circles) + len(areas.polygons)} areas is kept to")
    return areas


async def _counts_all(connection: Connection) -> bool:
    """Whether it must be in all areas to stay in: an ArduPilot, unless its FENCE_OPTIONS differ."""
    if connection.heartbeat.autopilot != mavlink.MAV_AUTOPILOT_ARDUPILOTMEGA:
        return False
    return not int(await parameter_or(connection, "FENCE_OPTIONS", 0.0)) & _ANY_INCLUSION
