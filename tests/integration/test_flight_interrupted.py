"""Links that fall silent for a moment or for minutes, cables that are pulled, vehicles that restart."""

import asyncio
import os
import pty
import tty
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager, suppress
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from tampered_link import PROVENANCE, Pilot, TamperedLink, connected, fly_with, straight, virtually

from companion import clock
from companion.autopilot import detect
from companion.errors import FlightError, GapError, TakenError, TrackingError
from companion.flight.approach import rest_to_rest
from companion.flight.flight import FlightPlan, fly
from companion.link import connect, start_telemetry
from companion.link.dialect import mavlink
from sitl.mavlink import MavlinkVehicle, open_vehicle

SETPOINT = mavlink.MAVLink_set_position_target_local_ned_message
PX4, ARDUPILOT = "bebop2", "arducopter_sitl"
FAR = rest_to_rest(np.array([0.0, 0.0, -2.0]), np.array([0.0, 8.0, -2.0]), "far")
both = pytest.mark.parametrize("vehicle", [PX4, ARDUPILOT])


def silence(link: TamperedLink, seconds: float) -> None:
    """Nothing passes for so long, in either direction."""
    link.incoming, link.outgoing = lambda message: None, lambda message: False

    def mended() -> None:
        link.incoming, link.outgoing = lambda message: message, lambda message: True

    asyncio.get_running_loop().call_later(seconds, mended)


@both
def test_a_moment_of_silence_ends_no_flight(vehicle: str) -> None:
    _, outcome, error = fly_with(TamperedLink(vehicle=vehicle), lambda link, pilot: silence(link, 0.3))
    assert error is None
    assert outcome is not None
    assert outcome.accuracy.max_m < 1.0


@pytest.mark.parametrize("silent_s", [1.5, 20.0, 120.0])
@both
def test_after_a_silence_the_flight_goes_on_when_asked(vehicle: str, silent_s: float) -> None:
    link = TamperedLink(vehicle=vehicle)

    async def scenario() -> None:
        async with connected(link) as pilot:

            def at(text: str) -> None:
                if text.startswith("tracking"):
                    asyncio.get_running_loop().call_later(6.0, silence, link, silent_s)

            pilot.on_announce = at
            with pytest.raises((GapError, TrackingError)):
                await pilot.fly(FlightPlan(FAR))
            pilot.on_announce = lambda text: None
            await asyncio.sleep(silent_s + 3.0)
            here, resumed_s = link.firmware.estimate.position.copy(), clock.now()
            assert 1.0 < here[1] < 7.5
            outcome = await pilot.fly(FlightPlan(FAR, resume=True))
            assert outcome.accuracy.max_m < 1.0
            sent = [each for time_s, each in link.sent if isinstance(each, SETPOINT) and time_s > resumed_s]
            np.testing.assert_allclose((sent[0].x, sent[0].y, sent[0].z), here, atol=0.3)
            assert min(each.y for each in sent) > here[1] - 0.5
            assert sent[-1].y == pytest.approx(8.0, abs=0.1)

    virtually(scenario())


@both
def test_a_vehicle_that_restarts_in_the_air_is_sent_nothing_and_flies_again_when_asked(vehicle: str) -> None:
    link = TamperedLink(vehicle=vehicle)
    restarted_s: list[float] = []

    def restart(link: TamperedLink, pilot: Pilot) -> None:
        restarted_s.append(clock.now())
        link.simulated.reboot()

    async def scenario() -> None:
        async with connected(link) as pilot:

            def at(text: str) -> None:
                if text.startswith("tracking"):
                    asyncio.get_running_loop().call_later(1.0, restart, link, pilot)

            pilot.on_announce = at
            with pytest.raises(TakenError):
                await pilot.fly(FlightPlan(straight()))
            await asyncio.sleep(8.0)
            assert not [time_s for time_s in link.setpoint_times() if time_s > restarted_s[0] + 0.25]
            pilot.on_announce = lambda text: None
            with pytest.raises(FlightError, match="nothing to resume"):
                await pilot.fly(FlightPlan(straight(), resume=True))
            outcome = await pilot.fly(FlightPlan(straight()))
            assert outcome.accuracy.max_m < 1.0
            gaps_s = np.diff([state for state in outcome.recording.states.time_s if state > outcome.start_s])
            assert gaps_s.max() < 0.05  # at the rate that was asked for, and asked for again

    virtually(scenario())


class Cable:
    """From a vehicle in real time to a pseudo-terminal, which is at `device` while it is plugged in."""

    def __init__(self, vehicle: MavlinkVehicle, device: Path) -> None:
        self._vehicle = vehicle
        self._device = device
        self._ends: tuple[int, int] | None = None

    def plug(self) -> None:
        self._ends = pty.openpty()
        tty.setraw(self._ends[0])
        os.set_blocking(self._ends[0], False)
        self._device.symlink_to(os.ttyname(self._ends[1]))

    def pull(self) -> None:
        ends, self._ends = self._ends, None
        assert ends is not None
        self._device.unlink()
        for end in ends:
            os.close(end)

    async def carry(self) -> None:
        began_s = clock.now()
        while True:
            with suppress(BlockingIOError):
                if self._ends is not None:
                    self._vehicle.receive(os.read(self._ends[0], 65536))
            for delivery in self._vehicle.advance(clock.now() - began_s):
                with suppress(BlockingIOError):
                    if self._ends is not None:
                        os.write(self._ends[0], delivery.data)
            await asyncio.sleep(0.005)


@asynccontextmanager
async def plugged(device: Path) -> AsyncIterator[Cable]:
    """A vehicle on a cable."""
    open_vehicle(PX4).advance(0.01)  # compiled before anybody waits
    cable = Cable(open_vehicle(PX4), device)
    cable.plug()
    carrying = asyncio.create_task(cable.carry())
    try:
        yield cable
    finally:
        carrying.cancel()
        await asyncio.wait([carrying])
        cable.pull()


@pytest.mark.realtime
async def test_a_cable_that_was_pulled_in_flight_is_plugged_in_again(tmp_path: Path) -> None:
    device = tmp_path / "ttyUSB0"
    plan = FlightPlan(straight(), settle_s=0.5)
    async with plugged(device) as cable, connect(f"serial://{device}:921600") as connection:
        telemetry = await start_telemetry(connection)
        autopilot = await detect(connection, telemetry)

        def at(text: str) -> None:
            if text.startswith("tracking"):
                asyncio.get_running_loop().call_later(1.0, cable.pull)

        with pytest.raises((GapError, TrackingError)):
            await fly(plan, autopilot, telemetry, provenance=PROVENANCE, announce=at)
        cable.plug()
        await telemetry.next_state(10.0)
        outcome = await fly(replace(plan, resume=True), autopilot, telemetry, provenance=PROVENANCE)
        assert outcome.accuracy.max_m < 1.0
