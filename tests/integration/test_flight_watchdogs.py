"""Flights that a watchdog ends, or lets go on more plainly: each action, and each thing that is watched."""

import asyncio
import math
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from tampered_link import POSCTL, PROVENANCE, Pilot, TamperedLink, connected, fly_with, straight, virtually

from companion import clock
from companion.errors import LinkError, TrackingError
from companion.flight.flight import After, FlightPlan, fly
from companion.flight.guard import GuardLimits
from companion.flight.online_correction import OnlineCorrection
from companion.flight.reference import Reference
from companion.flight.strategies import position_velocity, position_velocity_acceleration
from companion.flight.watchdogs import Action, Watchdog, WatchdogError, Watchdogs
from companion.learning.online_settings import DEFAULT
from companion.link.dialect import Message, mavlink
from companion.state import VehicleState
from companion.trajectory import Trajectory
from sitl.faults.kinds import EstimatorDrift

BATTERY = mavlink.MAVLink_sys_status_message
GPS = mavlink.MAVLink_gps_raw_int_message
ESTIMATOR = mavlink.MAVLink_estimator_status_message


def telling(kind: type[Message], **fields: float) -> Callable[[TamperedLink, Pilot], None]:
    """From now on, messages of a kind say something else."""

    def told(message: Any) -> Message:
        if isinstance(message, kind):
            for name, value in fields.items():
                setattr(message, name, value)
        return message  # type: ignore[no-any-return]

    return lambda link, pilot: setattr(link, "incoming", told)


def drift(link: TamperedLink, east_m_s: float) -> None:
    """From now on, the estimated position runs away."""
    link.simulated.simulation.faults.inject(EstimatorDrift(east_m_s=east_m_s))


def jump(seconds: float) -> None:
    loop = asyncio.get_running_loop()
    assert isinstance(loop, clock.VirtualTimeLoop)
    loop.jump(seconds)


@pytest.mark.parametrize(
    ("action", "mode", "last"),
    [
        (Action.HOLD, "HOLD", "state: holding"),
        (Action.LAND, "LAND", "state: standby"),
        (Action.RETURN, "RTL", "state: standby"),
        (Action.YIELD, "", "state: failed"),
    ],
)
def test_each_action_is_taken(action: Action, mode: str, last: str) -> None:
    link = TamperedLink()
    watchdogs = Watchdogs(battery_used=Watchdog(limit=0.9, lasts_s=1.0, action=action))
    plan = FlightPlan(straight(), limits=GuardLimits(watchdogs=watchdogs))
    trouble = telling(BATTERY, battery_remaining=5)
    pilot, _, error = fly_with(link, trouble, plan=plan)
    assert isinstance(error, WatchdogError)
    assert str(error) == "95% of the battery is used (watchdog battery_used, limit 0.9)"
    states = [text for _, text in pilot.recorder.events if text.startswith("state")]
    assert states[-1].startswith(last)
    if action is Action.YIELD:
        ended_s = link.setpoint_times()[-1]
        modes_s = link.commanded(mavlink.MAV_CMD_DO_SET_MODE)
        assert max(modes_s) < ended_s
    elif action is Action.HOLD:
        assert link.mode == mode
    else:
        assert not link.firmware.armed
        assert bool(link.commanded(mavlink.MAV_CMD_NAV_RETURN_TO_LAUNCH)) == (action is Action.RETURN)


@pytest.mark.parametrize(
    ("trouble", "name", "down"),
    [
        (telling(BATTERY, battery_remaining=4), "battery_used", True),
        (telling(GPS, fix_type=1), "gps_lost_s", True),
        (lambda link, _: drift(link, 0.8), "gps_apart_m", True),
        (telling(ESTIMATOR, flags=0), "estimator", False),
        (telling(ESTIMATOR, pos_horiz_ratio=1.5), "estimator", False),
        (lambda *_: jump(0.95), "lateness_s", False),
    ],
)
def test_each_thing_that_is_watched(
    trouble: Callable[[TamperedLink, Pilot], None], name: str, down: bool
) -> None:
    link = TamperedLink()
    _, _, error = fly_with(link, trouble)
    assert isinstance(error, WatchdogError)
    assert f"watchdog {name}" in str(error)
    assert link.firmware.armed is not down
    assert down or link.mode == "HOLD"


@pytest.mark.parametrize(
    ("trouble", "name"),
    [
        (lambda link, _: drift(link, 0.8), "gps_apart_m"),
        (telling(BATTERY, battery_remaining=4), "battery_used"),
    ],
)
def test_a_climb_is_watched_too(trouble: Callable[[TamperedLink, Pilot], None], name: str) -> None:
    link = TamperedLink()
    plan = FlightPlan(straight(), takeoff_altitude_m=8.0)
    pilot, _, error = fly_with(link, trouble, phase="taking off", after_s=2.0, plan=plan)
    assert isinstance(error, WatchdogError)
    assert f"watchdog {name}" in str(error)
    assert "going to the start" not in pilot.announced
    assert not link.firmware.armed


def test_a_vehicle_that_follows_nothing_is_noticed_although_it_is_near() -> None:
    def astray(trajectory: Trajectory, time_s: float, state: VehicleState) -> Reference:
        return Reference(trajectory.at(time_s).position + np.array([0.0, 2.65, 0.0]), np.zeros(3))

    link = TamperedLink()
    _, _, error = fly_with(link, lambda *_: None, plan=FlightPlan(straight(), astray))
    assert isinstance(error, TrackingError)
    assert "watchdog off_course_m" in str(error)
    assert link.mode == "HOLD"


def test_a_hot_computer_lands_its_vehicle() -> None:
    link = TamperedLink()

    async def scenario() -> None:
        async with connected(link) as pilot:
            await fly(
                FlightPlan(straight()),
                pilot.autopilot,
                pilot.telemetry,
                provenance=PROVENANCE,
                temperature_c=lambda: 99.0,
            )

    with pytest.raises(WatchdogError, match="processor is at 99 °C"):
        virtually(scenario())
    assert not link.firmware.armed


def slow_from(begin_s: float, seconds: float) -> Any:
    """A strategy whose steps begin to take long."""

    def law(trajectory: Trajectory, time_s: float, state: VehicleState) -> Reference:
        if trajectory.name == straight().name and time_s > begin_s:
            jump(seconds)
        return position_velocity_acceleration(trajectory, time_s, state)

    return law


def fell_back(pilot: Pilot) -> list[str]:
    return [text for text in pilot.announced if text.startswith("falling back on the plain strategy")]


@pytest.mark.parametrize("seconds", [0.03, 0.2])
def test_what_takes_too_long_is_flown_no_more(seconds: float) -> None:
    plan = FlightPlan(straight(), slow_from(1.0, seconds))
    pilot, outcome, error = fly_with(TamperedLink(), lambda *_: None, plan=plan)
    assert error is None
    (told,) = fell_back(pilot)
    assert "watchdog computing" in told
    assert outcome is not None
    sent = outcome.recording.references
    late = sent.time_s > outcome.start_s + 2.5
    assert all(math.isnan(number) for number in sent.acceleration[late, 0])


@pytest.mark.parametrize("phase", ["taking off", "going to the start"])
def test_a_fall_back_before_the_strategy_is_flown_is_told_and_lasts(phase: str) -> None:
    watchdogs = Watchdogs(battery_used=Watchdog(limit=0.9, action=Action.FALL_BACK))
    plan = FlightPlan(straight(), position_velocity_acceleration, limits=GuardLimits(watchdogs=watchdogs))
    trouble = telling(BATTERY, battery_remaining=5)
    pilot, outcome, error = fly_with(TamperedLink(), trouble, phase=phase, after_s=0.0, plan=plan)
    assert error is None
    (told,) = fell_back(pilot)
    assert pilot.announced.index(told) < pilot.announced.index("settling")
    assert outcome is not None
    assert np.isnan(outcome.recording.references.acceleration).all()


def test_a_flight_that_is_plain_has_nothing_to_fall_back_on() -> None:
    watchdogs = Watchdogs(battery_used=Watchdog(limit=0.9, action=Action.FALL_BACK))
    plan = FlightPlan(straight(), limits=GuardLimits(watchdogs=watchdogs))
    pilot, _, error = fly_with(TamperedLink(), telling(BATTERY, battery_remaining=5), plan=plan)
    assert error is None
    assert fell_back(pilot) == []


def test_a_flight_that_is_ended_listens_no_more() -> None:
    pilot, _, error = fly_with(TamperedLink(), telling(BATTERY, battery_remaining=5))
    assert isinstance(error, WatchdogError)
    assert pilot.telemetry._handlers == ()


def test_errors_that_nobody_predicted_end_the_learning_not_the_flight() -> None:
    class Blind(OnlineCorrection):
        def sent(self, *args: Any) -> Any:
            predicted = super().sent(*args)
            predicted.error[:] += [1.0, 0.0, 0.0]
            return predicted

    plan = FlightPlan(straight(), position_velocity, Blind(DEFAULT))
    pilot, outcome, error = fly_with(TamperedLink(), lambda *_: None, plan=plan)
    assert error is None
    (told,) = fell_back(pilot)
    assert "watchdog unpredicted_m" in told
    assert outcome is not None
    assert outcome.accuracy.max_m < 1.0


def test_an_ordinary_flight_alarms_nobody() -> None:
    plan = FlightPlan(straight(), position_velocity, OnlineCorrection(DEFAULT))
    pilot, outcome, error = fly_with(TamperedLink("realistic"), lambda *_: None, plan=plan)
    assert error is None
    assert fell_back(pilot) == []
    assert outcome is not None
    assert outcome.clips == {}


def test_a_pilot_who_takes_a_vehicle_that_a_watchdog_lands_keeps_it() -> None:
    link = TamperedLink()

    def trouble(link: TamperedLink, pilot: Pilot) -> None:
        telling(BATTERY, battery_remaining=4)(link, pilot)
        asyncio.get_running_loop().call_later(4.0, link.pilot_switches_to, POSCTL)

    _, _, error = fly_with(link, trouble)
    assert isinstance(error, WatchdogError)
    assert link.mode == "POSCTL"


def test_a_landing_that_loses_its_telemetry_is_left_to_land() -> None:
    link = TamperedLink()

    def trouble(link: TamperedLink, _: Pilot) -> None:
        link.incoming = lambda message: None

    plan = FlightPlan(straight(), after=After.LAND)
    pilot, _, error = fly_with(link, trouble, phase="landing", after_s=1.0, plan=plan)
    assert isinstance(error, LinkError)
    assert pilot.announced[-1] == "the vehicle is left to its landing"
    assert link.mode == "LAND"
