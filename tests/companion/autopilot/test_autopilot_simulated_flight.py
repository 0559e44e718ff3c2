"""The whole chain against the simulated vehicle, in virtual time and through the bytes."""

import asyncio

import numpy as np
import pytest

from companion import clock
from companion.arrays import Vec3
from companion.autopilot import Autopilot, detect
from companion.errors import RefusedError
from companion.link import Telemetry, connect, start_telemetry
from companion.link.status import Landed


async def stream(autopilot: Autopilot, position: Vec3) -> None:
    due_s = clock.now()
    while True:
        autopilot.send_setpoint(position, np.zeros(3))
        due_s += 0.02
        await clock.sleep_until(due_s)


async def airborne(telemetry: Telemetry, autopilot: Autopilot) -> Vec3:
    """Take off to 2 m; the position there."""
    await telemetry.next_state()
    await autopilot.arm()
    await autopilot.takeoff(2.0)
    return (await telemetry.next_state()).position


@pytest.mark.parametrize("conditions", ["ideal", "realistic"])
def test_takeoff_offboard_hold_and_landing(conditions: str) -> None:
    async def scenario() -> None:
        async with connect(f"sitl://bebop2?conditions={conditions}&seed=3") as connection:
            telemetry = await start_telemetry(connection)
            autopilot = await detect(connection, telemetry)
            goal = await airborne(telemetry, autopilot) + np.array([1.0, 0.0, -0.5])
            streaming = connection.spawn(stream(autopilot, goal))
            await autopilot.engage()
            await asyncio.sleep(8.0)
            np.testing.assert_allclose((await telemetry.next_state()).position, goal, atol=0.35)
            await autopilot.hold()
            streaming.cancel()
            assert autopilot.mode == "AUTO.LOITER"
            await autopilot.land()
            assert telemetry.status.landed is Landed.ON_GROUND
            assert not telemetry.status.armed

    clock.run(scenario(), virtual=True)


def test_offboard_without_a_stream_is_refused_with_the_reason() -> None:
    async def scenario() -> None:
        async with connect("sitl://bebop2") as connection:
            telemetry = await start_telemetry(connection)
            autopilot = await detect(connection, telemetry)
            await airborne(telemetry, autopilot)
            with pytest.raises(RefusedError, match="no offboard setpoints"):
                await autopilot.engage()

    clock.run(scenario(), virtual=True)


def test_a_stream_that_stops_is_noticed_as_the_vehicles_failsafe() -> None:
    async def scenario() -> None:
        async with connect("sitl://bebop2") as connection:
            telemetry = await start_telemetry(connection)
            autopilot = await detect(connection, telemetry)
            streaming = connection.spawn(stream(autopilot, await airborne(telemetry, autopilot)))
            await autopilot.engage()
            streaming.cancel()
            async with asyncio.timeout(5.0):
                assert await autopilot.until_taken() != "OFFBOARD"
            assert not autopilot.engaged

    clock.run(scenario(), virtual=True)
