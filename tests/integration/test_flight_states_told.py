"""The states that real flights come to, one after another, and how each flight ends in its own."""

import math

import numpy as np
import pytest
from tampered_link import POSCTL, Pilot, TamperedLink, connected, fly_with, straight, virtually, without

from companion.errors import FlightError
from companion.flight.flight import After, FlightPlan
from companion.flight.states import FlightState
from companion.link.dialect import mavlink

_WAY = ["standby", "taking off", "approaching", "tracking"]


def states(pilot: Pilot) -> list[str]:
    """Without the reasons."""
    told = (text for _, text in pilot.recorder.events if text.startswith("state: "))
    return [text.removeprefix("state: ").split(" (")[0] for text in told]


@pytest.mark.parametrize(
    ("after", "end"),
    [
        (After.HOLD, ["holding"]),
        (After.LAND, ["holding", "landing", "standby"]),
        (After.RETURN, ["holding", "landing", "standby"]),
    ],
)
def test_a_flight_comes_to_one_state_after_another(after: After, end: list[str]) -> None:
    plan = FlightPlan(straight(), after=after)
    pilot, _, error = fly_with(TamperedLink(), lambda *_: None, plan=plan)
    assert error is None
    assert states(pilot) == _WAY + end


def test_a_pilot_who_takes_the_vehicle_is_told_of_as_such() -> None:
    pilot, _, error = fly_with(TamperedLink(), lambda link, _: link.pilot_switches_to(POSCTL))
    assert error is not None
    assert states(pilot) == [*_WAY, FlightState.YIELDED]


def test_what_ends_in_a_hold_is_told_of_as_such() -> None:
    lost = without(mavlink.MAVLink_attitude_message)
    pilot, _, _ = fly_with(TamperedLink(), lambda link, _: setattr(link, "incoming", lost))
    assert states(pilot) == [*_WAY, FlightState.HOLDING]


def test_a_vehicle_that_fell_silent_is_disconnected() -> None:
    def trouble(link: TamperedLink, pilot: Pilot) -> None:
        link.incoming, link.outgoing = lambda message: None, lambda message: False

    pilot, _, _ = fly_with(TamperedLink(), trouble)
    assert states(pilot) == [*_WAY, FlightState.DISCONNECTED]


def test_a_vehicle_found_in_the_air_holds() -> None:
    async def scenario() -> list[str]:
        async with connected(TamperedLink()) as pilot:
            await pilot.fly(FlightPlan(straight()))
            pilot.recorder.events.clear()
            await pilot.fly(FlightPlan(straight(), resume=True))
            return states(pilot)

    assert virtually(scenario()) == ["standby", "holding", "approaching", "tracking", "holding"]


def test_on_the_ground_a_flight_that_fails_stands_by() -> None:
    far = straight(end=np.array([math.pi, 0.0, -2.0]))
    link = TamperedLink()
    pilot, _, error = fly_with(link, lambda *_: None, plan=FlightPlan(far, resume=True))
    assert isinstance(error, FlightError)
    assert states(pilot) == ["standby"]
