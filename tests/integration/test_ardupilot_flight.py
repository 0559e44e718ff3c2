"""Flights of the built-in ArduPilot vehicle, through the bytes and in virtual time."""

import asyncio
import socket
from dataclasses import astuple, replace
from pathlib import Path

import numpy as np
import pytest
import yaml
from tampered_link import PROVENANCE, Pilot, TamperedLink, connected, fly_with, straight, virtually, without

from companion import bundled, clock
from companion.autopilot import detect
from companion.autopilot.interface import MotionLimits
from companion.errors import RefusedError, TakenError, TrackingError
from companion.flight.flight import After, FlightPlan, fly
from companion.flight.guard import GuardLimits
from companion.flight.strategies import position_velocity_acceleration
from companion.flight.watchdogs import Watchdog, Watchdogs
from companion.link import connect, start_telemetry
from companion.link.dialect import mavlink
from sitl.endpoints import Endpoint, ardupilot_endpoints
from sitl.firmware.interface import Mode
from sitl.mavlink import open_vehicle
from sitl.server import Served, serve

ARM, TAKEOFF = mavlink.MAV_CMD_COMPONENT_ARM_DISARM, mavlink.MAV_CMD_NAV_TAKEOFF
SET_MODE, LAND = mavlink.MAV_CMD_DO_SET_MODE, mavlink.MAV_CMD_NAV_LAND
LOITER = (5, 0)
GUID_TIMEOUT_S = 3.0

PATIENT = Watchdogs(state_age_s=Watchdog(limit=5.0), lateness_s=Watchdog(limit=5.0))


def ardupilot(conditions: str = "ideal", vehicle: str = "arducopter_sitl") -> TamperedLink:
    return TamperedLink(conditions, vehicle)


def speed_m_s(link: TamperedLink) -> float:
    return float(np.linalg.norm(link.firmware.estimate.velocity))


@pytest.mark.parametrize("conditions", ["ideal", "realistic"])
def test_from_the_ground_to_the_ground(conditions: str) -> None:
    link = ardupilot(conditions)
    plan = FlightPlan(straight(), position_velocity_acceleration, after=After.LAND)
    pilot, outcome, _ = fly_with(link, lambda *_: None, plan=plan)
    assert outcome is not None
    phases = [text.split()[0] for text in pilot.announced]
    assert phases == ["arming", "taking", "going", "settling", "tracking", "holding", "landing"]
    assert outcome.accuracy.max_m < 0.4
    assert not link.firmware.armed
    assert -link.firmware.estimate.position[2] < 0.2
    (armed_s,), (off_s,) = link.commanded(ARM), link.commanded(TAKEOFF)
    assert link.commanded(SET_MODE)[0] < armed_s < off_s < link.setpoint_times()[0]


def test_it_is_left_in_brake_without_setpoints() -> None:
    link = ardupilot()
    fly_with(link, lambda *_: None)
    assert link.mode == "BRAKE"
    assert link.setpoint_times()[-1] < link.commanded(SET_MODE)[-1] + 1.5


def test_a_vehicle_in_the_air_is_not_sent_up_again() -> None:
    link = ardupilot()

    async def scenario() -> None:
        async with connected(link) as pilot:
            await pilot.fly(FlightPlan(straight()))
            outcome = await pilot.fly(FlightPlan(straight()))
            assert any(text.startswith("already in the air") for text in pilot.announced)
            np.testing.assert_allclose(outcome.trajectory.at(0.0).position, [0.0, 0.0, -2.0], atol=0.05)

    virtually(scenario())
    assert len(link.commanded(TAKEOFF)) == 1


def test_a_vehicle_that_refuses_to_arm_says_why(tmp_path: Path) -> None:
    file = bundled.find("vehicles", "arducopter_sitl", ".yaml")
    vehicle = yaml.safe_load(file.read_text())
    vehicle["ardupilot_parameters"]["BATT_LOW_VOLT"] = 14.0
    low = tmp_path / "low.yaml"
    low.write_text(yaml.safe_dump(vehicle))
    link = ardupilot(vehicle=str(low))
    pilot, _, error = fly_with(link, lambda *_: None)
    assert isinstance(error, RefusedError)
    assert "COMPONENT_ARM_DISARM (FAILED): Arm: Battery failsafe" in str(error)
    assert pilot.announced[-1].startswith("not ready, trying for up to 60 s")
    assert not link.commanded(TAKEOFF)


def test_a_vehicle_that_does_not_know_where_it_is_is_waited_for() -> None:
    link = ardupilot()
    link.incoming = without(mavlink.MAVLink_local_position_ned_message)

    def found(link: TamperedLink, pilot: Pilot) -> None:
        link.incoming = lambda message: message

    _, outcome, _ = fly_with(link, found, phase="waiting", after_s=25.0)
    assert outcome is not None
    assert link.commanded(ARM)[0] > 25.0


@pytest.mark.parametrize("phase", ["taking off", "going", "settling", "tracking", "landing"])
def test_a_pilot_who_takes_the_vehicle_keeps_it(phase: str) -> None:
    link = ardupilot()
    taken_s: list[float] = []

    def trouble(link: TamperedLink, pilot: Pilot) -> None:
        taken_s.append(clock.now())
        link.pilot_switches_to(LOITER)

    after_s = 0.5 if phase == "going" else 2.0
    plan = FlightPlan(straight(), after=After.LAND)
    _, _, error = fly_with(link, trouble, phase=phase, after_s=after_s, plan=plan)
    assert isinstance(error, TakenError)
    assert "went to LOITER unasked" in str(error)
    assert link.mode == "HOLD"
    until_heartbeat_s = 1.1
    assert all(time_s < taken_s[0] + until_heartbeat_s for time_s in link.setpoint_times())
    assert all(time_s < taken_s[0] for time_s in link.commanded(SET_MODE))


def test_a_link_that_goes_dead_leaves_the_vehicle_to_stop_by_itself() -> None:
    def trouble(link: TamperedLink, pilot: Pilot) -> None:
        link.incoming, link.outgoing = lambda message: None, lambda message: False

    link = ardupilot()
    pilot, _, error = fly_with(link, trouble)
    assert isinstance(error, TrackingError)
    assert pilot.announced[-1].startswith("could not be told to hold")
    assert link.mode == "OFFBOARD"
    assert speed_m_s(link) < 0.2


def test_without_setpoints_it_stops_and_stays_in_guided() -> None:
    async def scenario() -> None:
        async with connected(link) as pilot:
            await pilot.autopilot.arm()
            await pilot.autopilot.takeoff(2.0)
            await pilot.autopilot.engage()
            for _ in range(100):
                pilot.autopilot.send_setpoint(None, np.array([1.0, 0.0, 0.0]))
                await asyncio.sleep(0.02)
            await asyncio.sleep(GUID_TIMEOUT_S - 0.5)
            assert speed_m_s(link) > 0.8
            await asyncio.sleep(2.5)
            assert speed_m_s(link) < 0.1
            assert (pilot.autopilot.mode, pilot.autopilot.engaged) == ("GUIDED", True)

    link = ardupilot()
    virtually(scenario())


def test_its_motion_limits_are_found() -> None:
    async def scenario() -> MotionLimits:
        async with connected(ardupilot()) as pilot:
            return await pilot.autopilot.motion_limits()

    assert astuple(virtually(scenario())) == pytest.approx((2.5, 1.5, 2.5, 1.0))


def test_the_same_flight_gives_the_same_states() -> None:
    def states() -> bytes:
        _, outcome, _ = fly_with(ardupilot("realistic"), lambda *_: None)
        assert outcome is not None
        return outcome.recording.states.position.tobytes()

    assert states() == states()


@pytest.mark.realtime
async def test_it_is_flown_over_udp() -> None:
    open_vehicle("arducopter_sitl").advance(0.01)  # compiled before anybody waits
    vehicle = open_vehicle("arducopter_sitl")
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as free:
        free.bind(("127.0.0.1", 0))
        port = int(free.getsockname()[1])
    endpoint, *_ = ardupilot_endpoints()
    assert isinstance(endpoint, Endpoint)
    async with asyncio.TaskGroup() as group:
        at_port = replace(endpoint, peer=("127.0.0.1", port))
        serving = group.create_task(serve([Served(vehicle, [at_port])], say=lambda line: None))
        async with connect(f"udpin://127.0.0.1:{port}") as connection:
            telemetry = await start_telemetry(connection)
            autopilot = await detect(connection, telemetry)
            plan = FlightPlan(
                straight(),
                position_velocity_acceleration,
                settle_s=0.5,
                limits=GuardLimits(watchdogs=PATIENT),  # a busy machine is no fault of the link
            )
            outcome = await fly(plan, autopilot, telemetry, provenance=PROVENANCE)
        serving.cancel()
    assert outcome.accuracy.max_m < 1.0
    assert vehicle.simulation.firmware.mode is Mode.BRAKE
