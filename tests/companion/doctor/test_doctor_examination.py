from functools import partial

import pytest
from waking_vehicle import WakingVehicle

from companion import clock
from companion.autopilot import detect
from companion.doctor import Observation, Severity, Traffic, examine, judge
from companion.link import start_telemetry
from companion.link.address import Simulated
from companion.link.connection import Connection, connect_over
from companion.link.dialect import mavlink
from companion.link.opening import open_transport

HARMLESS = {
    mavlink.MAV_CMD_REQUEST_MESSAGE,
    mavlink.MAV_CMD_SET_MESSAGE_INTERVAL,
    mavlink.MAV_CMD_RUN_PREARM_CHECKS,
}


def seen_of(vehicle: WakingVehicle, patience_s: float) -> tuple[Observation, list[str]]:
    announced: list[str] = []

    async def scenario() -> Observation:
        traffic = Traffic()
        async with connect_over(traffic.watching(vehicle.open)) as connection:
            return await examine(
                connection, traffic, seconds=5.0, patience_s=patience_s, announce=announced.append
            )

    return clock.run(scenario(), virtual=True), announced


def stopping(seen: Observation) -> set[str]:
    return {finding.topic for finding in judge(seen) if finding.severity is Severity.STOPS}


def test_a_vehicle_that_boots_is_waited_for() -> None:
    vehicle = WakingVehicle(ready_s=25.0)
    seen, announced = seen_of(vehicle, 60.0)
    assert stopping(seen) == set()
    assert 24.0 < seen.waited_s < 30.0
    assert any("waiting for the estimator's horizontal position" in line for line in announced)
    assert (seen.identity.autopilot, seen.identity.version, seen.identity.uid) == (
        "ArduPilot",
        "4.6.0",
        "abc",
    )
    assert (seen.mode, seen.armed, seen.vehicle_type) == ("STABILIZE", False, "quadrotor")
    assert (seen.health.battery, seen.health.gps_fix, seen.health.has_home) == (0.87, 3, True)
    assert seen.parameters == {"GUID_TIMEOUT": 3.0, "ARMING_CHECK": 1.0}
    assert seen.streams["LOCAL_POSITION_NED"].rate_hz == pytest.approx(50.0, rel=0.05)
    assert seen.losses[1, 1].lost == 0
    assert seen.round_trips is not None


def test_patience_ends_and_the_vehicles_reason_is_told() -> None:
    seen, _ = seen_of(WakingVehicle(ready_s=1e6), 20.0)
    assert 20.0 <= seen.waited_s < 25.0
    assert stopping(seen) == {"estimator", "arming", "LOCAL_POSITION_NED"}
    assert seen.complaints == ("PreArm: Need Position Estimate",)


def test_nothing_of_the_vehicle_is_changed() -> None:
    vehicle = WakingVehicle(ready_s=3.0)
    seen_of(vehicle, 10.0)
    assert set(vehicle.commands) == HARMLESS
    assert mavlink.MAVLINK_MSG_ID_PARAM_SET not in vehicle.heard
    assert mavlink.MAVLINK_MSG_ID_SET_MODE not in vehicle.heard


def test_a_vehicle_that_only_heartbeats_is_told_in_bounded_time() -> None:
    seen, _ = seen_of(WakingVehicle(ready_s=0.0, answers=False), 5.0)
    assert {"estimator", "LOCAL_POSITION_NED", "ATTITUDE"} <= stopping(seen)
    assert seen.identity.version is None
    assert seen.round_trips is None
    assert seen.waited_s < 30.0


@pytest.mark.parametrize("vehicle", ["bebop2", "arducopter_sitl"])
def test_a_vehicle_in_flight_flies_on(vehicle: str) -> None:
    async def scenario() -> tuple[Observation, str, str, float]:
        traffic = Traffic()
        opener = partial(open_transport, Simulated(vehicle))
        async with connect_over(traffic.watching(opener)) as connection:
            before, height_m = await _up(connection)
            seen = await examine(
                connection, traffic, seconds=3.0, patience_s=30.0, announce=lambda text: None
            )
            telemetry = await start_telemetry(connection)
            now = await telemetry.next_state()
            return seen, before, seen.mode, height_m + float(now.position[2])

    seen, before, after, sunk_m = clock.run(scenario(), virtual=True)
    assert seen.armed
    assert before == after
    assert abs(sunk_m) < 0.5
    assert seen.waited_s < 3.0
    assert stopping(seen) == set()


async def _up(connection: Connection) -> tuple[str, float]:
    """Two metres up; the mode and the height there."""
    telemetry = await start_telemetry(connection)
    await telemetry.next_state(60.0)
    autopilot = await detect(connection, telemetry)
    await autopilot.arm()
    await autopilot.takeoff(2.0)
    await autopilot.hold()
    state = await telemetry.next_state()
    return autopilot.mode, -float(state.position[2])
