import asyncio
import math
from collections.abc import Callable, Coroutine
from contextlib import nullcontext
from typing import Any

import numpy as np
import pytest
from fake_autopilots import LOITER, OFFBOARD, POSCTL, FakePx4, accepted, refused

from companion import clock
from companion.autopilot.detect import Identity, detect, identify
from companion.autopilot.px4 import Px4, mode_name
from companion.errors import FlightError, LinkError, NoReplyError, RefusedError, TakenError
from companion.link.dialect import mavlink

ARM = mavlink.MAV_CMD_COMPONENT_ARM_DISARM
TAKEOFF = 4 << 16 | 2 << 24
SET_MODE = mavlink.MAV_CMD_DO_SET_MODE


def with_px4(test: Callable[[FakePx4, Px4], Coroutine[Any, Any, None]]) -> Callable[[], None]:
    """Run a test in virtual time, with a scripted vehicle and what flies it."""

    async def scenario() -> None:
        vehicle = FakePx4()
        async with vehicle.flown() as (connection, telemetry):
            await telemetry.next_state()
            await test(vehicle, Px4(connection, telemetry))

    return lambda: clock.run(scenario(), virtual=True)


@pytest.mark.parametrize(
    ("custom_mode", "name"),
    [(OFFBOARD, "OFFBOARD"), (LOITER, "AUTO.LOITER"), (POSCTL, "POSCTL"), (9 << 16 | 8 << 24, "mode 9.8")],
)
def test_modes_have_their_names(custom_mode: int, name: str) -> None:
    assert mode_name(custom_mode) == name


@with_px4
async def test_arm_returns_when_the_vehicle_is_armed(vehicle: FakePx4, px4: Px4) -> None:
    await px4.arm()
    assert vehicle.armed
    assert vehicle.mode == LOITER
    asked = len(vehicle.commands)
    await px4.arm()
    assert len(vehicle.commands) == asked


@with_px4
async def test_a_vehicle_that_refuses_to_arm_says_why(vehicle: FakePx4, px4: Px4) -> None:
    vehicle.answers[ARM] = lambda: refused(ARM, "Arming denied: battery low")
    with pytest.raises(RefusedError, match="Arming denied: battery low"):
        await px4.arm()


@with_px4
async def test_a_vehicle_that_accepts_but_does_not_arm_is_told(vehicle: FakePx4, px4: Px4) -> None:
    vehicle.answers[ARM] = lambda: [accepted(ARM)]
    with pytest.raises(FlightError, match=r"it did not arm within 3 s; mode AUTO\.LOITER"):
        await px4.arm()


@with_px4
async def test_takeoff_asks_for_an_altitude_above_the_sea(vehicle: FakePx4, px4: Px4) -> None:
    await px4.takeoff(2.5)
    sent = vehicle.commands[-1]
    assert sent.command == mavlink.MAV_CMD_NAV_TAKEOFF
    assert sent.param7 == pytest.approx(490.5)
    assert math.isnan(sent.param4)
    assert vehicle.altitude_m == pytest.approx(2.5)


@with_px4
async def test_a_takeoff_that_goes_nowhere_ends_in_time(vehicle: FakePx4, px4: Px4) -> None:
    takeoff = mavlink.MAV_CMD_NAV_TAKEOFF
    vehicle.answers[takeoff] = lambda: [accepted(takeoff)]
    with pytest.raises(FlightError, match=r"did not climb to 2\.5 m within 15 s"):
        await px4.takeoff(2.5)


async def take_off(px4: Px4, *, taken: bool) -> None:
    """Climb; if `taken`, to be told that somebody else has the vehicle."""
    told = pytest.raises(TakenError, match=r"went to AUTO\.LOITER unasked, in its climb")
    with told if taken else nullcontext():
        await px4.takeoff(2.5)


@pytest.mark.parametrize(
    ("climbed_m", "radius_m", "taken"), [(2.0, None, False), (1.0, None, True), (1.0, 1.5, False)]
)
def test_a_hold_far_below_the_altitude_is_somebodys(
    climbed_m: float, radius_m: float | None, taken: bool
) -> None:
    @with_px4
    async def scenario(vehicle: FakePx4, px4: Px4) -> None:
        def stop() -> list[Any]:
            vehicle.altitude_m, vehicle.mode = climbed_m, LOITER
            return [accepted(mavlink.MAV_CMD_NAV_TAKEOFF)]

        vehicle.parameters = {} if radius_m is None else {"NAV_MC_ALT_RAD": radius_m}
        vehicle.answers[mavlink.MAV_CMD_NAV_TAKEOFF] = stop
        await px4.arm()
        await take_off(px4, taken=taken)
        assert vehicle.altitude_m == climbed_m

    scenario()


@with_px4
async def test_a_climb_whose_height_is_not_told_is_nobodys(vehicle: FakePx4, px4: Px4) -> None:
    def fall_silent() -> list[Any]:
        vehicle.altitude_m, vehicle.mode, vehicle.knows_where_it_is = 2.4, LOITER, False
        return [accepted(mavlink.MAV_CMD_NAV_TAKEOFF)]

    vehicle.answers[mavlink.MAV_CMD_NAV_TAKEOFF] = fall_silent
    await px4.arm()
    with pytest.raises(LinkError, match="no position"):
        await px4.takeoff(2.5)


@pytest.mark.parametrize(("intended", "taken"), [(TAKEOFF, True), (LOITER, False), (0, False)])
def test_a_hold_that_nobody_chose_is_a_failsafes(intended: int, taken: bool) -> None:
    @with_px4
    async def scenario(vehicle: FakePx4, px4: Px4) -> None:
        def stop() -> list[Any]:
            vehicle.altitude_m, vehicle.mode = 2.1, LOITER
            return [
                mavlink.MAVLink_current_mode_message(0, LOITER, intended),
                accepted(mavlink.MAV_CMD_NAV_TAKEOFF),
            ]

        vehicle.answers[mavlink.MAV_CMD_NAV_TAKEOFF] = stop
        await px4.arm()
        await take_off(px4, taken=taken)
        assert vehicle.mode == LOITER

    scenario()


@pytest.mark.parametrize("obeys", [True, False])
def test_a_mode_that_is_seen_needs_no_answer(obeys: bool) -> None:
    @with_px4
    async def scenario(vehicle: FakePx4, px4: Px4) -> None:
        def say_nothing() -> list[Any]:
            vehicle.mode = LOITER if obeys else POSCTL
            return []

        vehicle.answers[SET_MODE] = say_nothing
        if obeys:
            await px4.hold()
        else:
            with pytest.raises(NoReplyError, match="did not answer DO_SET_MODE, asked 2 times"):
                await px4.hold()
        assert px4.mode == ("AUTO.LOITER" if obeys else "POSCTL")

    scenario()


@with_px4
async def test_engage_goes_to_offboard_and_hold_leaves_it(vehicle: FakePx4, px4: Px4) -> None:
    await px4.engage()
    assert px4.mode == "OFFBOARD"
    assert [px4.engaged] == [True]
    taken = asyncio.create_task(px4.until_taken())
    await px4.hold()
    assert px4.mode == "AUTO.LOITER"
    assert [px4.engaged] == [False]
    await asyncio.sleep(2.0)
    assert not taken.done()  # we asked for it
    taken.cancel()


@with_px4
async def test_engage_is_tried_again_until_the_stream_was_seen(vehicle: FakePx4, px4: Px4) -> None:
    def answer() -> Any:
        if len(vehicle.commands) < 2:
            return refused(SET_MODE, "no offboard setpoints")
        vehicle.mode = OFFBOARD
        return [accepted(SET_MODE)]

    vehicle.answers[SET_MODE] = answer
    await px4.engage()
    assert len(vehicle.commands) == 2


@with_px4
async def test_engage_gives_up_with_the_vehicles_reason(vehicle: FakePx4, px4: Px4) -> None:
    vehicle.answers[SET_MODE] = lambda: refused(SET_MODE, "no offboard setpoints")
    with pytest.raises(RefusedError, match="no offboard setpoints"):
        await px4.engage()
    assert not px4.engaged


@with_px4
async def test_a_pilot_who_takes_the_vehicle_is_noticed(vehicle: FakePx4, px4: Px4) -> None:
    await px4.engage()
    asyncio.get_running_loop().call_later(1.0, setattr, vehicle, "mode", POSCTL)
    before_s = clock.now()
    async with asyncio.timeout(5.0):
        assert await px4.until_taken() == "POSCTL"
    assert clock.now() < before_s + 1.3
    assert not px4.engaged


@with_px4
async def test_land_returns_when_the_vehicle_is_down_and_disarmed(vehicle: FakePx4, px4: Px4) -> None:
    await px4.arm()
    await px4.takeoff(2.0)
    await px4.land()
    assert not vehicle.armed


@with_px4
async def test_setpoints_go_out_at_once(vehicle: FakePx4, px4: Px4) -> None:
    px4.send_setpoint(np.array([1.0, 2.0, -3.0]), np.zeros(3))
    await asyncio.sleep(0)
    (sent,) = vehicle.setpoints
    assert (sent.x, sent.y, sent.z, sent.type_mask) == (1.0, 2.0, -3.0, 3520)


def test_a_vehicle_that_falls_silent_is_told() -> None:
    async def scenario() -> None:
        vehicle = FakePx4()
        vehicle.altitude_m, vehicle.armed = 2.0, True
        async with vehicle.flown() as (connection, telemetry):
            await telemetry.next_state()
            land = mavlink.MAV_CMD_NAV_LAND
            vehicle.answers[land] = lambda: [accepted(land)]
            asyncio.get_running_loop().call_later(1.0, setattr, vehicle, "_live", lambda: None)
            with pytest.raises(LinkError, match="fell silent"):
                await Px4(connection, telemetry).land()
            assert clock.now() < 10.0

    clock.run(scenario(), virtual=True)


def test_a_px4_is_found_and_identified() -> None:
    async def scenario() -> None:
        vehicle = FakePx4()
        capabilities = mavlink.MAV_PROTOCOL_CAPABILITY_SET_POSITION_TARGET_LOCAL_NED
        version = mavlink.MAVLink_autopilot_version_message(
            capabilities, 1 << 24 | 16 << 16 | 2 << 8 | 255, 0, 0, 0, [0] * 8, [0] * 8, [0] * 8, 0, 0, 0
        )
        vehicle.answers[mavlink.MAV_CMD_REQUEST_MESSAGE] = lambda: [version]
        async with vehicle.flown() as (connection, telemetry):
            assert await identify(connection) == Identity("PX4", "1.16.2", takes_setpoints=True)
            assert isinstance(await detect(connection, telemetry), Px4)

    clock.run(scenario(), virtual=True)


def test_a_px4_that_does_not_tell_its_version_is_flown_all_the_same() -> None:
    async def scenario() -> None:
        async with FakePx4().flown() as (connection, telemetry):
            assert isinstance(await detect(connection, telemetry), Px4)

    clock.run(scenario(), virtual=True)


def test_other_autopilots_cannot_be_flown() -> None:
    async def scenario() -> None:
        async with FakePx4(autopilot=1).flown() as (connection, telemetry):
            with pytest.raises(
                FlightError, match=r"autopilot 1 vehicles .* connect to one of PX4 or ArduPilot"
            ):
                await detect(connection, telemetry)

    clock.run(scenario(), virtual=True)


@pytest.mark.parametrize("autopilot", [mavlink.MAV_AUTOPILOT_PX4, mavlink.MAV_AUTOPILOT_ARDUPILOTMEGA])
def test_only_multirotors_are_flown(autopilot: int) -> None:
    async def scenario() -> None:
        vehicle = FakePx4(autopilot)
        vehicle.type = mavlink.MAV_TYPE_GROUND_ROVER
        async with vehicle.flown() as (connection, telemetry):
            with pytest.raises(FlightError, match=r"\(MAV_TYPE 10\) is no multirotor"):
                await detect(connection, telemetry)

    clock.run(scenario(), virtual=True)
