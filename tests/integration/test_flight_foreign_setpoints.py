"""Flights on which the vehicle follows setpoints that are not ours."""

from typing import Any

import pytest
from tampered_link import Pilot, TamperedLink, Trouble, fly_with, straight

from companion.flight.flight import FlightPlan
from companion.flight.watchdogs import WatchdogError
from companion.link.dialect import Message, mavlink
from sitl.faults.reading import parse_fault

TOLD = mavlink.MAVLink_position_target_local_ned_message
PLAN = FlightPlan(straight())


def in_turns(link: TamperedLink, pilot: Pilot) -> None:
    """From now on, each fourth setpoint that the vehicle follows is three metres beside."""
    count = 0

    def told(message: Any) -> Message:
        nonlocal count
        if isinstance(message, TOLD):
            count += 1
            message.y += 3.0 if count % 4 == 0 else 0.0
        return message  # type: ignore[no-any-return]

    link.incoming = told


def stuck(link: TamperedLink, pilot: Pilot) -> None:
    """From now on, the vehicle follows none that come."""
    link.simulated.simulation.faults.inject(parse_fault("setpoints_ignored"))


@pytest.mark.parametrize("vehicle", ["bebop2", "arducopter_sitl"])
@pytest.mark.parametrize("trouble", [in_turns, stuck])
def test_setpoints_that_are_not_ours_end_in_a_hold(trouble: Trouble, vehicle: str) -> None:
    link = TamperedLink(vehicle=vehicle)
    _, _, error = fly_with(link, trouble, plan=PLAN)
    assert isinstance(error, WatchdogError)
    assert "are not ours: does another program send? (watchdog foreign, limit 0.1)" in str(error)
    assert link.mode in ("HOLD", "BRAKE")


@pytest.mark.parametrize("mask", [0x7, 0x1])
def test_a_vehicle_that_tells_no_position_is_flown_all_the_same(mask: int) -> None:
    def masked(message: Any) -> Message:
        if isinstance(message, TOLD):
            message.type_mask, message.y = mask, message.y + 3.0
        return message  # type: ignore[no-any-return]

    _, _, error = fly_with(TamperedLink(), lambda link, pilot: setattr(link, "incoming", masked), plan=PLAN)
    assert error is None
