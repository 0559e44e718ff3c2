import asyncio
from collections.abc import Callable, Coroutine
from dataclasses import astuple
from typing import Any

import numpy as np
import pytest
from fake_autopilots import BRAKE, GUIDED, STABILIZE, FakeArduPilot, accepted, refused

from companion import clock
from companion.autopilot.ardupilot import ArduPilot, mode_name
from companion.autopilot.detect import detect
from companion.errors import LinkError, NoReplyError, RefusedError, TakenError
from companion.link.dialect import mavlink

ARM, TAKEOFF = mavlink.MAV_CMD_COMPONENT_ARM_DISARM, mavlink.MAV_CMD_NAV_TAKEOFF
SET_MODE = mavlink.MAV_CMD_DO_SET_MODE
Test = Callable[[FakeArduPilot, ArduPilot], Coroutine[Any, Any, None]]


def with_ardupilot(test: Test) -> Callable[[], None]:
    """Run a test in virtual time, with a scripted vehicle and what flies it."""

    async def scenario() -> None:
        vehicle = FakeArduPilot()
        async with vehicle.flown() as (connection, telemetry):
            autopilot = await detect(connection, telemetry)
            assert isinstance(autopilot, ArduPilot)
            await telemetry.next_state()
            vehicle.commands.clear()
            await test(vehicle, autopilot)

    return lambda: clock.run(scenario(), virtual=True)


def commands(vehicle: FakeArduPilot) -> list[int]:
    return [message.command for message in vehicle.commands]


@pytest.mark.parametrize(
    ("number", "name"), [(4, "GUIDED"), (17, "BRAKE"), (0, "STABILIZE"), (99, "mode 99")]
)
def test_modes_have_their_names(number: int, name: str) -> None:
    assert mode_name(number) == name


@with_ardupilot
async def test_it_is_in_guided_before_it_is_armed(vehicle: FakeArduPilot, autopilot: ArduPilot) -> None:
    await autopilot.arm()
    assert commands(vehicle) == [SET_MODE, ARM]
    assert (vehicle.mode, vehicle.armed) == (GUIDED, True)


@with_ardupilot
async def test_it_is_not_armed_before_it_knows_where_it_is(
    vehicle: FakeArduPilot, autopilot: ArduPilot
) -> None:
    vehicle.knows_where_it_is = False
    asyncio.get_running_loop().call_later(25.0, setattr, vehicle, "knows_where_it_is", True)
    began_s = clock.now()
    await autopilot.arm()
    assert clock.now() > began_s + 24.0

    vehicle.knows_where_it_is, vehicle.armed = False, False
    with pytest.raises(LinkError, match=r"no position and attitude .* within 30 s"):
        await autopilot.arm()
    assert not vehicle.armed


@with_ardupilot
async def test_a_vehicle_that_refuses_to_arm_says_why(vehicle: FakeArduPilot, autopilot: ArduPilot) -> None:
    vehicle.answers[ARM] = lambda: refused(ARM, "Arm: Compass not calibrated")
    with pytest.raises(RefusedError, match="Arm: Compass not calibrated"):
        await autopilot.arm()


@with_ardupilot
async def test_takeoff_asks_for_an_altitude_above_home(vehicle: FakeArduPilot, autopilot: ArduPilot) -> None:
    vehicle.altitude_m = 1.0  # on a roof
    await autopilot.arm()
    await autopilot.takeoff(2.5)
    assert vehicle.commands[-1].command == TAKEOFF
    assert vehicle.commands[-1].param7 == pytest.approx(3.5)


@with_ardupilot
async def test_a_refused_takeoff_tells_what_it_needs(vehicle: FakeArduPilot, autopilot: ArduPilot) -> None:
    with pytest.raises(RefusedError, match=r"NAV_TAKEOFF \(FAILED\).* armed, in GUIDED \(now STABILIZE\)"):
        await autopilot.takeoff(2.5)


@with_ardupilot
async def test_a_pilot_who_takes_it_in_the_climb_is_noticed(
    vehicle: FakeArduPilot, autopilot: ArduPilot
) -> None:
    vehicle.answers[TAKEOFF] = lambda: [accepted(TAKEOFF)]
    await autopilot.arm()
    asyncio.get_running_loop().call_later(2.0, setattr, vehicle, "mode", STABILIZE)
    with pytest.raises(TakenError, match="went to STABILIZE unasked"):
        await autopilot.takeoff(2.5)


@with_ardupilot
async def test_engage_goes_to_guided_and_hold_to_brake(vehicle: FakeArduPilot, autopilot: ArduPilot) -> None:
    await autopilot.engage()
    assert (vehicle.mode, autopilot.engaged) == (GUIDED, True)
    taken = asyncio.create_task(autopilot.until_taken())
    await autopilot.hold()
    assert (vehicle.mode, autopilot.engaged) == (BRAKE, False)
    await asyncio.sleep(2.0)
    assert not taken.done()
    taken.cancel()


@with_ardupilot
async def test_a_pilot_who_takes_the_vehicle_is_noticed(vehicle: FakeArduPilot, autopilot: ArduPilot) -> None:
    await autopilot.engage()
    asyncio.get_running_loop().call_later(1.0, setattr, vehicle, "mode", STABILIZE)
    async with asyncio.timeout(5.0):
        assert await autopilot.until_taken() == "STABILIZE"
    assert not autopilot.engaged


@with_ardupilot
async def test_land_returns_when_the_vehicle_is_down_and_disarmed(
    vehicle: FakeArduPilot, autopilot: ArduPilot
) -> None:
    await autopilot.arm()
    await autopilot.takeoff(2.0)
    await autopilot.land()
    assert not vehicle.armed
    assert autopilot.mode == "LAND"


@pytest.mark.parametrize(
    "parameters",
    [
        {"WPNAV_SPEED_UP": 250.0, "WPNAV_SPEED_DN": 150.0, "WPNAV_ACCEL": 300.0, "WPNAV_ACCEL_Z": 100.0},
        {"WP_SPD_UP": 2.5, "WP_SPD_DN": 1.5, "WP_ACC": 3.0, "WP_ACC_Z": 1.0},
    ],
)
def test_motion_limits_are_found_by_their_old_and_new_names(parameters: dict[str, float]) -> None:
    async def test(vehicle: FakeArduPilot, autopilot: ArduPilot) -> None:
        vehicle.parameters = parameters
        assert astuple(await autopilot.motion_limits()) == pytest.approx((2.5, 1.5, 3.0, 1.0))

    with_ardupilot(test)()


@with_ardupilot
async def test_motion_limits_that_it_does_not_tell(vehicle: FakeArduPilot, autopilot: ArduPilot) -> None:
    with pytest.raises(NoReplyError, match="none of WPNAV_SPEED_UP, WP_SPD_UP"):
        await autopilot.motion_limits()


PLACE, FORWARD, LIFT = np.array([1.0, 2.0, -3.0]), np.array([0.5, 0.0, 0.0]), np.array([0.0, 0.0, -1.0])


@pytest.mark.parametrize(
    ("channels", "mask"),
    [
        ((PLACE,), 3576),
        ((None, FORWARD), 3527),
        ((None, None, LIFT), 3135),
        ((PLACE, FORWARD), 3520),
        ((PLACE, FORWARD, LIFT), 3072),
        ((PLACE, None, LIFT), 3576),
    ],
    ids=["P", "V", "A", "PV", "PVA", "PA is no combination"],
)
def test_setpoints_have_only_masks_that_guided_takes(channels: tuple[Any, ...], mask: int) -> None:
    async def test(vehicle: FakeArduPilot, autopilot: ArduPilot) -> None:
        autopilot.send_setpoint(*channels)
        await asyncio.sleep(0)
        (sent,) = vehicle.setpoints
        assert (sent.type_mask, sent.coordinate_frame) == (mask, mavlink.MAV_FRAME_LOCAL_NED)

    with_ardupilot(test)()
