"""A flight in real time beside other work, and what is said of its setpoints."""

from dataclasses import replace

import pytest
from tampered_link import straight

from companion.experiments.loaded import Regularity, fly_loaded
from companion.experiments.simulated_flights import Scenario
from companion.flight.strategies import Strategy
from companion.priority import Priority

STEADY = Regularity(0.02, 1000, 0.02, 0.021, 0.03, "", 0.01, 2, Priority.NORMAL)


@pytest.mark.realtime
def test_setpoints_go_on_beside_a_busy_process() -> None:
    told = fly_loaded(Scenario(straight(), Strategy.GP), 1, with_priority=True)
    assert told.failsafe == ""
    assert told.setpoints > 100
    assert told.p50_s == pytest.approx(told.nominal_s, rel=0.5)
    assert told.rms_m < 1.0


def test_setpoints_that_are_late_or_end_do_not_hold() -> None:
    assert STEADY.holds
    assert not replace(STEADY, p99_s=0.025).holds
    assert not replace(STEADY, failsafe="no telemetry").holds
