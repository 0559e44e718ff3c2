"""A link that loses 5 % of all frames each way, doubles 2 %, puts 2 % behind later ones; 50 ms of jitter."""

import numpy as np
import pytest

from companion import clock
from companion.autopilot import detect
from companion.flight.approach import rest_to_rest
from companion.flight.flight import FlightOutcome, FlightPlan, fly
from companion.link import connect, start_telemetry
from companion.recording import Provenance


def flown(vehicle: str, seed: int) -> tuple[FlightOutcome, list[str]]:
    """A few metres along a line, and a landing; with what the vehicle said."""
    start, end = np.array([0.0, 0.0, -2.0]), np.array([3.0, 0.0, -2.5])
    plan = FlightPlan(rest_to_rest(start, end, "straight"))

    async def scenario() -> tuple[FlightOutcome, list[str]]:
        async with connect(f"sitl://{vehicle}?conditions=lossy&seed={seed}") as connection:
            telemetry = await start_telemetry(connection)
            autopilot = await detect(connection, telemetry)
            outcome = await fly(plan, autopilot, telemetry, provenance=Provenance(vehicle=vehicle))
            await autopilot.land()
            return outcome, [line.text for line in connection.status_texts]

    return clock.run(scenario(), virtual=True)


@pytest.mark.parametrize("vehicle", ["px4_sih", "bebop2"])
@pytest.mark.parametrize("seed", [1, 2, 3])
def test_a_tracked_flight_succeeds(vehicle: str, seed: int) -> None:
    outcome, said = flown(vehicle, seed)
    assert outcome.accuracy.rms_m < 0.5
    assert said
