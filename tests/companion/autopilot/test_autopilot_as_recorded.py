"""The habits of real autopilots, one by one: each has cost somebody a flight."""

import asyncio
from collections.abc import Callable, Coroutine
from typing import Any

import numpy as np
import pytest
from fake_autopilots import LOITER, OFFBOARD, POSCTL, accepted
from recorded_autopilots import ARM, TAKEOFF, RecordedArduPilot, RecordedPx4

from companion import clock
from companion.autopilot import Autopilot, detect
from companion.errors import RefusedError
from companion.flight.takeoff import home_of, is_flying, take_off
from companion.link import Telemetry, start_telemetry
from companion.link.dialect import mavlink

SET_MODE = mavlink.MAV_CMD_DO_SET_MODE


def flown(
    vehicle: RecordedPx4 | RecordedArduPilot,
    test: Callable[[Autopilot, Telemetry, list[str]], Coroutine[Any, Any, None]],
) -> list[str]:
    """Connect to it as a flight does, and run the test; what was announced."""
    announced: list[str] = []

    async def scenario() -> None:
        async with vehicle.flown() as (connection, _):
            telemetry = await start_telemetry(connection)
            await test(await detect(connection, telemetry), telemetry, announced)

    clock.run(scenario(), virtual=True)
    return announced


async def off_the_ground(autopilot: Autopilot, telemetry: Telemetry, announced: list[str]) -> None:
    assert not await is_flying(telemetry, announced.append)
    await take_off(autopilot, telemetry, 2.5, announced.append)


def test_an_ardupilot_that_has_just_been_switched_on_takes_off() -> None:
    vehicle = RecordedArduPilot()
    announced = flown(vehicle, off_the_ground)
    assert vehicle.altitude_m > 2.19
    assert vehicle.now_s < 45.0
    assert announced[0] == "waiting until the vehicle knows its position"
    (told,) = [text for text in announced if text.startswith("not ready")]
    assert "PreArm: Need Position Estimate" in told


def test_a_px4_that_refuses_to_arm_for_half_a_minute_takes_off() -> None:
    vehicle = RecordedPx4()
    vehicle.ready_at_s = 30.0
    announced = flown(vehicle, off_the_ground)
    assert 30.0 < vehicle.now_s < 40.0
    assert [text.split()[0] for text in announced] == ["arming", "not", "taking"]
    assert "ekf2 missing data" in announced[1]


def test_a_px4_that_disarms_itself_while_it_refuses_to_take_off_is_armed_again() -> None:
    vehicle = RecordedPx4()
    vehicle.takes_off_at_s = 20.0
    announced = flown(vehicle, off_the_ground)
    assert vehicle.altitude_m > 2.19
    assert [message.command for message in vehicle.commands].count(ARM) == 2
    assert sum("Takeoff denied!" in text for text in announced) == 1


def test_a_px4_that_never_gets_ready_is_given_up_with_its_reason() -> None:
    vehicle = RecordedPx4()
    vehicle.ready_at_s = 500.0
    with pytest.raises(RefusedError, match="ekf2 missing data"):
        flown(vehicle, off_the_ground)
    assert 58.0 < vehicle.now_s < 65.0


def test_a_takeoff_that_px4_ends_a_little_too_low_is_over() -> None:
    vehicle = RecordedPx4()
    vehicle.stops_below_m = 0.7
    flown(vehicle, off_the_ground)
    assert vehicle.mode == LOITER
    assert vehicle.altitude_m == pytest.approx(1.8)


@pytest.mark.parametrize("telemetry_hz", [4.0, 30.0, 50.0])
def test_what_is_sent_is_used_at_the_rate_at_which_it_comes(telemetry_hz: float) -> None:
    vehicle = RecordedPx4()
    vehicle.telemetry_hz = telemetry_hz
    states: list[float] = []

    async def test(autopilot: Autopilot, telemetry: Telemetry, announced: list[str]) -> None:
        telemetry.subscribe(lambda state: states.append(state.time_s))
        await off_the_ground(autopilot, telemetry, announced)

    flown(vehicle, test)
    assert np.median(np.diff(states)) == pytest.approx(1.0 / telemetry_hz, abs=2e-3)


def test_offboard_that_is_acknowledged_twice_does_not_answer_the_hold() -> None:
    vehicle = RecordedPx4()

    async def test(autopilot: Autopilot, telemetry: Telemetry, announced: list[str]) -> None:
        await off_the_ground(autopilot, telemetry, announced)
        await autopilot.engage()
        assert vehicle.mode == OFFBOARD
        await autopilot.hold()
        assert vehicle.mode == LOITER

    flown(vehicle, test)


@pytest.mark.parametrize("late_s", [0.3, 0.7, 1.2])
def test_an_acknowledgement_may_be_late(late_s: float) -> None:
    vehicle = RecordedPx4()

    def answer() -> list[Any]:
        vehicle.armed = True
        asyncio.get_running_loop().call_later(late_s, vehicle.say, accepted(ARM))
        return []

    async def test(autopilot: Autopilot, telemetry: Telemetry, announced: list[str]) -> None:
        vehicle.answers[ARM] = answer
        await off_the_ground(autopilot, telemetry, announced)
        assert vehicle.altitude_m > 2.19

    flown(vehicle, test)


def test_a_takeoff_in_progress_is_waited_for() -> None:
    vehicle = RecordedPx4()

    def answer() -> list[Any]:
        progress = mavlink.MAVLink_command_ack_message(TAKEOFF, mavlink.MAV_RESULT_IN_PROGRESS)
        asyncio.get_running_loop().call_later(3.0, vehicle.say, accepted(TAKEOFF))
        vehicle._climb(2.5)
        return [progress]

    async def test(autopilot: Autopilot, telemetry: Telemetry, announced: list[str]) -> None:
        vehicle.answers[TAKEOFF] = answer
        await off_the_ground(autopilot, telemetry, announced)
        assert [message.command for message in vehicle.commands].count(TAKEOFF) == 1

    flown(vehicle, test)


@pytest.mark.parametrize("make", [RecordedPx4, RecordedArduPilot])
def test_a_landing_takes_its_time_and_ends_disarmed(
    make: Callable[[], RecordedPx4 | RecordedArduPilot],
) -> None:
    vehicle = make()

    async def test(autopilot: Autopilot, telemetry: Telemetry, announced: list[str]) -> None:
        await off_the_ground(autopilot, telemetry, announced)
        began_s = clock.now()
        await autopilot.land()
        assert clock.now() > began_s + 7.9
        assert not telemetry.status.armed

    flown(vehicle, test)


def test_a_pilot_is_seen_before_the_next_heartbeat_and_others_are_not_taken_for_one() -> None:
    vehicle = RecordedPx4()

    async def test(autopilot: Autopilot, telemetry: Telemetry, announced: list[str]) -> None:
        await off_the_ground(autopilot, telemetry, announced)
        await autopilot.engage()
        await asyncio.sleep(5.37)  # heartbeats of a gimbal, a ground station and another vehicle pass by
        assert autopilot.engaged
        vehicle.mode = POSCTL
        async with asyncio.timeout(0.1):
            assert await autopilot.until_taken() == "POSCTL"

    flown(vehicle, test)


def test_home_is_where_the_vehicle_now_says_it_is() -> None:
    async def test(autopilot: Autopilot, telemetry: Telemetry, announced: list[str]) -> None:
        early = await home_of(telemetry, announced.append)
        await asyncio.sleep(20.0)
        late = await home_of(telemetry, announced.append)
        assert late[2] == pytest.approx(early[2] - 0.2, abs=0.02)

    assert flown(RecordedPx4(), test) == []
