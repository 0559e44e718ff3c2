"""A whole flight, when all goes well: phases, setpoints without a gap, the same bytes each time."""

import asyncio
from pathlib import Path

import numpy as np
import pytest
from tampered_link import PROVENANCE, TamperedLink, connected, straight, virtually

from companion.flight.flight import After, FlightOutcome, FlightPlan
from companion.flight.online_correction import OnlineCorrection
from companion.flight.strategies import position_velocity_acceleration
from companion.learning.correction import ConstantGain
from companion.learning.online_settings import DEFAULT, PAPER, OnlineSettings
from companion.link.dialect import mavlink
from companion.recording import write_recording


async def flown(link: TamperedLink, settings: OnlineSettings, *, after: After = After.HOLD) -> FlightOutcome:
    async with connected(link) as pilot:
        outcome = await pilot.fly(
            FlightPlan(
                straight(),
                position_velocity_acceleration,
                OnlineCorrection(settings),
                period_s=settings.sample_time_s,
                after=after,
            )
        )
        await asyncio.sleep(2.0)  # whether anything goes on after the flight
        return outcome


SEVEN_HERTZ = PAPER.model_copy(update={"gain": ConstantGain(alpha=(0.5, 0.5, 0.5))})
"""As slow as the paper's, but gentle: its own gains are too much for this vehicle."""


@pytest.mark.parametrize("settings", [DEFAULT, SEVEN_HERTZ], ids=["default", "7 Hz"])
@pytest.mark.parametrize("conditions", ["ideal", "realistic"])
def test_setpoints_never_pause_from_the_first_to_the_hold(settings: OnlineSettings, conditions: str) -> None:
    link = TamperedLink(conditions)
    recording = virtually(flown(link, settings)).recording
    sent_s = link.setpoint_times()
    assert np.diff(sent_s).max() < 0.5
    np.testing.assert_array_equal(recording.references.time_s, sent_s)
    modes_s = link.commanded(mavlink.MAV_CMD_DO_SET_MODE)
    assert sent_s[0] < modes_s[0]
    assert modes_s[-1] - settings.sample_time_s <= sent_s[-1] < modes_s[-1] + 1.5
    assert link.mode == "HOLD"


def test_the_recording_spans_takeoff_to_hold() -> None:
    recording = virtually(flown(TamperedLink(), DEFAULT)).recording
    assert -recording.states.position[0, 2] < 0.1
    assert recording.states.time_s[-1] >= recording.references.time_s[-1]
    phases = [text.split()[0] for _, text in recording.events if not text.startswith(("guard", "state"))]
    assert phases == ["arming", "taking", "going", "settling", "tracking", "holding"]


def test_landing_follows_a_hold() -> None:
    link = TamperedLink()
    recording = virtually(flown(link, DEFAULT, after=After.LAND)).recording
    assert not link.firmware.armed
    (landed_s,) = link.commanded(mavlink.MAV_CMD_NAV_LAND)
    # Setpoints that the vehicle does not follow would be taken for its response in training.
    assert recording.references.time_s[-1] <= landed_s


def test_a_vehicle_in_the_air_is_not_sent_up_again() -> None:
    link = TamperedLink()

    async def scenario() -> None:
        async with connected(link) as pilot:
            await pilot.fly(FlightPlan(straight()))
            outcome = await pilot.fly(FlightPlan(straight()))
            assert any(text.startswith("already in the air") for text in pilot.announced)
            np.testing.assert_allclose(outcome.trajectory.at(0.0).position, [0.0, 0.0, -2.0], atol=0.05)

    virtually(scenario())
    assert len(link.commanded(mavlink.MAV_CMD_NAV_TAKEOFF)) == 1


def test_the_same_flight_gives_the_same_bytes(tmp_path: Path) -> None:
    files = [tmp_path / "first.mcap", tmp_path / "second.mcap"]
    for file in files:
        outcome = virtually(flown(TamperedLink("realistic"), DEFAULT))
        assert outcome.recording.provenance == PROVENANCE
        write_recording(outcome.recording, file)
    assert files[0].read_bytes() == files[1].read_bytes()
