"""The vehicle's own fence, for the guard of a flight."""

from companion.errors import LinkError, NoReplyError
from companion.flight.fence import Areas
from companion.flight.takeoff import Announce
from companion.flight.vehicle_fence import VehicleFence
from companion.link.connection import Connection
from companion.link.telemetry import Telemetry
from companion.mission.boundaries import areas_of
from companion.mission.fence_parameters import bounds_of, counts_all, fence_parameters
from companion.mission.site import vehicle_site
from companion.mission.transfer import download_fence


async def vehicle_fence(connection: Connection, telemetry: Telemetry, announce: Announce) -> VehicleFence:
    """The fence that the vehicle has, north and east of its takeoff point; none where it tells none.

    Raises:
        LinkError: it has one, but does not come to know its position.
    """
    values = await fence_parameters(connection, announce)
    bounds = bounds_of(values)
    if bounds:
        announce(f"the vehicle's own limits are kept to: {bounds}")
    areas = await _areas(connection, telemetry, announce)
    return VehicleFence(
        circles=areas.circles, polygons=areas.polygons, in_all=counts_all(values), bounds=bounds
    )


async def _areas(connection: Connection, telemetry: Telemetry, announce: Announce) -> Areas:
    try:
        fence = await download_fence(connection)
    except LinkError:
        announce("the vehicle tells no areas of its fence: only the guard's are kept to")
        return Areas()
    if not (fence.polygons or fence.circles):
        return Areas()
    try:
        site = await vehicle_site(connection, telemetry)
    except NoReplyError as unknown:
        announce(f"the vehicle's fence cannot be placed ({unknown}): only the guard's is kept to")
        return Areas()
    areas = areas_of(fence, site)
    announce(f"the vehicle's own fence of {len(areas.circles) + len(areas.polygons)} areas is kept to")
    return areas
