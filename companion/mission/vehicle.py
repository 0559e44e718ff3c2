"""Scripts for a vehicle: connect, build a mission, upload it, fly it item by item, land."""

import math
from collections.abc import AsyncIterator, Awaitable, Callable
from contextlib import asynccontextmanager, suppress
from typing import TypeVar

from companion import clock
from companion.autopilot import Autopilot, detect
from companion.errors import RefusedError
from companion.geodesy import Place, geodetic_from_ned
from companion.link import connect, start_telemetry
from companion.link.address import Address, Simulated, parse_address
from companion.link.command import set_message_interval
from companion.link.connection import Connection
from companion.link.dialect import mavlink
from companion.link.telemetry import Telemetry
from companion.mission.builder import Mission
from companion.mission.items import MissionItem, Plan
from companion.mission.progress import Reached, fly_mission
from companion.mission.site import Site, vehicle_site
from companion.mission.transfer import download_plan, upload_plan

T = TypeVar("T")

_BATTERY_HZ = 1.0


@asynccontextmanager
async def vehicle(address: str | Address, *, system_id: int | None = None) -> AsyncIterator["Drone"]:
    """Connect to the vehicle at `address`, until the block ends; waits until it knows where it is.

    Example:
        >>> from companion.mission import Mission, vehicle
        >>> async def survey() -> None:
        ...     async with vehicle("udpin://0.0.0.0:14540") as drone:
        ...         mission = Mission().takeoff(5).survey((0, 0), (20, 10), 8, spacing_m=5)
        ...         await drone.upload(mission)
        ...         async for reached in drone.fly():
        ...             print(f"item {reached.index + 1} of {reached.total}: {reached.item.name}")
        ...         await drone.land()

    Args:
        address: a connection string; `sitl://bebop2` for the built-in vehicle.
        system_id: of the vehicle; without it, the first vehicle that is heard.

    Raises:
        InputError: the connection string is wrong.
        LinkError: no vehicle is there, or it tells no position.
        FlightError: it is none that this program can fly.
    """
    async with connect(address, system_id=system_id) as connection:
        telemetry = await start_telemetry(connection)
        with suppress(RefusedError):  # then it sends at its own rate
            await set_message_interval(connection, mavlink.MAVLINK_MSG_ID_SYS_STATUS, _BATTERY_HZ)
        autopilot = await detect(connection, telemetry)
        yield Drone(connection, telemetry, autopilot, await vehicle_site(connection, telemetry))


def run(script: Callable[["Drone"], Awaitable[T]], address: str, *, system_id: int | None = None) -> T:
    """Run a script with the vehicle at `address`: in virtual time for `sitl://`, else in real time.

    Raises:
        ImpromptuError: as `vehicle`, and whatever the script raises.
    """

    async def whole() -> T:
        async with vehicle(address, system_id=system_id) as drone:
            return await script(drone)

    return clock.run(whole(), virtual=isinstance(parse_address(address), Simulated))


class Drone:
    """A connected vehicle, for scripts; made by `vehicle`.

    Attributes:
        connection: its messages in, ours out.
        telemetry: its newest state and status.
        autopilot: what flies it.
        site: where it is on the earth.
    """

    def __init__(
        self, connection: Connection, telemetry: Telemetry, autopilot: Autopilot, site: Site
    ) -> None:
        self.connection = connection
        self.telemetry = telemetry
        self.autopilot = autopilot
        self.site = site
        self._mission: tuple[MissionItem, ...] | None = None

    @property
    def home(self) -> Place:
        """Where metres count from: its takeoff point."""
        return geodetic_from_ned(self.site.takeoff, self.site.origin, self.site.earth)

    @property
    def battery(self) -> float:
        """Remaining charge (0 to 1); NaN while it does not tell."""
        battery = self.telemetry.status.battery
        return math.nan if battery is None else battery

    @property
    def position(self) -> tuple[float, float, float]:
        """Metres north and east of home, and above it; NaN until it tells."""
        if self.telemetry.state is None:
            return math.nan, math.nan, math.nan
        north, east, down = self.telemetry.state.position - self.site.takeoff
        return float(north), float(east), -float(down)

    async def upload(self, mission: Mission | Plan) -> None:
        """Upload a mission, or a plan with its fence and rally points, and read it back.

        Raises:
            RefusedError, NoReplyError, FlightError, InputError: as `upload_plan`.
        """
        plan = mission.plan(self.home, self.site.earth) if isinstance(mission, Mission) else mission
        await upload_plan(self.connection, plan)
        self._mission = plan.mission

    async def download(self) -> Plan:
        """The plan that it has; raises as `download_plan`."""
        return await download_plan(self.connection)

    async def fly(self) -> AsyncIterator[Reached]:
        """Fly the mission that was uploaded, or that it has, and tell each item as it is reached.

        Leaving the loop early leaves the vehicle to its mission: tell it what to do instead.

        Raises:
            TakenError: it went to another mode unasked, and is left to whoever did that.
            RefusedError, NoReplyError, FlightError, LinkError: as `fly_mission`.
        """
        if self._mission is None:
            self._mission = (await self.download()).mission
        async for reached in fly_mission(self.connection, self.telemetry, self.autopilot, self._mission):
            yield reached

    async def takeoff(self, altitude_m: float) -> None:
        """Arm and climb to `altitude_m` above where it is; returns when it is there."""
        await self.autopilot.arm()
        await self.autopilot.takeoff(altitude_m)

    async def hold(self) -> None:
        """Hold where it is."""
        await self.autopilot.hold()

    async def land(self) -> None:
        """Land here; returns when it is on the ground and disarmed."""
        await self.autopilot.land()

    async def return_home(self) -> None:
        """Return in the autopilot's own way; returns when it is on the ground and disarmed."""
        await self.autopilot.return_home()
