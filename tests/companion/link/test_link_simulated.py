import asyncio
import sys

import pytest

from companion import clock
from companion.errors import InputError, LinkError
from companion.link.connecting import connect
from companion.link.simulated import SimulatedTransport
from companion.link.telemetry import start_telemetry
from companion.state import VehicleState


async def states_of(address: str, duration_s: float) -> list[VehicleState]:
    async with connect(address) as connection:
        telemetry = await start_telemetry(connection)
        states: list[VehicleState] = []
        telemetry.subscribe(states.append)
        await asyncio.sleep(duration_s)
    return states


def as_bytes(states: list[VehicleState]) -> list[bytes]:
    return [
        repr((state.time_s, state.received_s)).encode() + state.position.tobytes() + state.attitude.tobytes()
        for state in states
    ]


def test_the_same_seed_gives_the_same_flight_to_the_last_bit() -> None:
    def fly(seed: int) -> list[bytes]:
        address = f"sitl://bebop2?conditions=realistic&seed={seed}"
        return as_bytes(clock.run(states_of(address, 3.0), virtual=True))

    assert fly(1) == fly(1)
    assert fly(1) != fly(2)


def test_states_come_at_100_hz_with_the_time_at_which_they_held() -> None:
    states = clock.run(states_of("sitl://bebop2", 3.0), virtual=True)
    assert 290 <= len(states) <= 300
    assert all(0.0 <= state.received_s - state.time_s < 0.01 for state in states[50:])


def test_late_telemetry_shows_its_age() -> None:
    states = clock.run(states_of("sitl://bebop2?conditions=realistic", 5.0), virtual=True)
    ages_s = [state.received_s - state.time_s for state in states[200:]]
    assert sum(ages_s) / len(ages_s) == pytest.approx(0.02, abs=0.008)


def test_the_vehicle_stands_still_while_nothing_waits_and_after_the_end() -> None:
    async def scenario() -> None:
        async with connect("sitl://bebop2") as connection:
            transport = connection.transport
            assert isinstance(transport, SimulatedTransport)
            assert transport.vehicle.simulation.time_s < 0.1
            await asyncio.sleep(1.0)
            assert transport.vehicle.simulation.time_s == pytest.approx(clock.now() - transport.epoch_s)
            stopped_s = transport.vehicle.simulation.time_s
        await asyncio.sleep(1.0)
        assert transport.vehicle.simulation.time_s == stopped_s

    clock.run(scenario(), virtual=True)


def test_a_vehicle_that_is_not_there_is_wrong_input() -> None:
    async def scenario() -> None:
        with pytest.raises(InputError, match="no_such_vehicle"):
            async with connect("sitl://no_such_vehicle"):
                pytest.fail("it is not there")

    clock.run(scenario(), virtual=True)


def test_a_missing_simulator_is_told_with_what_to_install(monkeypatch: pytest.MonkeyPatch) -> None:
    async def scenario() -> None:
        monkeypatch.setitem(sys.modules, "sitl.mavlink", None)
        with pytest.raises(LinkError, match=r"pip install 'impromptu\[sim\]'"):
            async with connect("sitl://bebop2"):
                pytest.fail("it is not there")

    clock.run(scenario(), virtual=True)
