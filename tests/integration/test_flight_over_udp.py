"""Flights over UDP on this machine, in real time, on vehicles served as `companion sitl` serves them."""

import asyncio
import math
import socket
from collections.abc import AsyncIterator, Sequence
from contextlib import asynccontextmanager

import pytest
from tampered_link import PROVENANCE, straight

from companion.autopilot import detect
from companion.errors import LinkError
from companion.flight.flight import FlightOutcome, FlightPlan, fly
from companion.flight.guard import GuardLimits
from companion.flight.watchdogs import Watchdog, Watchdogs
from companion.link import connect, start_telemetry
from sitl.endpoints import Endpoint
from sitl.mavlink import OFFBOARD, MavlinkVehicle, open_vehicle
from sitl.server import Served, serve

pytestmark = pytest.mark.realtime

PATIENT = Watchdogs(state_age_s=Watchdog(limit=5.0), lateness_s=Watchdog(limit=5.0))


@pytest.fixture
def port() -> int:
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as free:
        free.bind(("127.0.0.1", 0))
        return int(free.getsockname()[1])


@asynccontextmanager
async def served(port: int, system_ids: Sequence[int]) -> AsyncIterator[dict[int, MavlinkVehicle]]:
    """Vehicles that all send to `port`."""
    open_vehicle("bebop2").advance(0.01)  # compiled before anybody waits
    vehicles = {system_id: open_vehicle("bebop2", system_id=system_id) for system_id in system_ids}
    async with asyncio.TaskGroup() as group:
        endpoint = Endpoint(OFFBOARD, 0, ("127.0.0.1", port))
        serving = [
            group.create_task(serve([Served(vehicle, [endpoint])], say=lambda line: None))
            for vehicle in vehicles.values()
        ]
        yield vehicles
        for task in serving:
            task.cancel()


async def flown(port: int, system_id: int | None = None) -> FlightOutcome:
    async with connect(f"udpin://127.0.0.1:{port}", system_id=system_id) as connection:
        telemetry = await start_telemetry(connection)
        autopilot = await detect(connection, telemetry)
        limits = GuardLimits(watchdogs=PATIENT)  # a busy machine is no fault of the link
        plan = FlightPlan(straight(), settle_s=0.5, limits=limits)
        return await fly(plan, autopilot, telemetry, provenance=PROVENANCE)


async def test_only_the_vehicle_that_was_connected_to_is_steered(port: int) -> None:
    async with served(port, [1, 2, 3]) as vehicles:
        outcome = await flown(port, system_id=2)
        modes = {system_id: vehicle.simulation.firmware.mode.name for system_id, vehicle in vehicles.items()}
        armed = [system_id for system_id, vehicle in vehicles.items() if vehicle.simulation.firmware.armed]
    assert armed == [2]
    assert modes[2] == "HOLD"
    # The others are on the ground all the while: a position of theirs would show as an error.
    assert outcome.accuracy.max_m < 1.0
    assert math.isfinite(outcome.accuracy.rms_m)


async def test_a_system_that_is_not_there_is_told_from_those_that_are(port: int) -> None:
    async with served(port, [1, 3]):
        with pytest.raises(LinkError, match="system 2 is silent, but these speak: 1, 3"):
            async with connect(f"udpin://127.0.0.1:{port}", system_id=2, timeout_s=0.7):
                pass


async def test_nothing_there_is_told(port: int) -> None:
    with pytest.raises(LinkError, match="no vehicle heard within"):
        async with connect(f"udpin://127.0.0.1:{port}", timeout_s=0.1):
            pass
