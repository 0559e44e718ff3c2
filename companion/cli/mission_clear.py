"""`companion mission clear`: no plan in a vehicle."""

from rich.console import Console

from companion.cli import options
from companion.cli.endpoint import Endpoint, with_vehicle
from companion.cli.lines import show
from companion.link import Connection
from companion.mission.transfer import clear_plan


def clear(
    connect: options.Connect,
    system_id: options.SystemId = None,
    signing_key: options.SigningKeyFile = None,
) -> None:
    """Delete a vehicle's mission, fence and rally points.

    Example: companion mission clear --connect udpin://0.0.0.0:14540
    """

    async def work(connection: Connection) -> int:
        await clear_plan(connection)
        return connection.system_id

    cleared = with_vehicle(Endpoint(connect, system_id, options.signing_key(signing_key)), work)
    show(Console(), f"system {cleared} has no mission, no fence and no rally points now")
