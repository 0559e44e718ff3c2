"""Whoever takes the vehicle keeps it, its own failsafe included; and how a flight goes on when asked to."""

import asyncio
import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from tampered_link import Pilot, TamperedLink, connected, fly_with, straight, virtually

from companion import clock
from companion.arrays import Vec3
from companion.errors import FlightError, GapError, RefusedError, TakenError, TrackingError
from companion.flight.approach import rest_to_rest
from companion.flight.flight import After, FlightPlan
from companion.flight.guard import GuardLimits
from companion.flight.heading import YawMode
from companion.flight.reference import Reference
from companion.flight.strategies import position_velocity
from companion.flight.watchdogs import Watchdog, Watchdogs
from companion.link.dialect import Message, mavlink
from companion.state import VehicleState
from companion.trajectory import Trajectory

SETPOINT = mavlink.MAVLink_set_position_target_local_ned_message
COMMAND = mavlink.MAVLink_command_long_message
PX4, ARDUPILOT = "bebop2", "arducopter_sitl"
OTHER_MODE = {PX4: (3, 0), ARDUPILOT: (5, 0)}
FAR = rest_to_rest(np.array([0.0, 0.0, -2.0]), np.array([0.0, 8.0, -2.0]), "far")
both = pytest.mark.parametrize("vehicle", [PX4, ARDUPILOT])


def asked(link: TamperedLink, since_s: float) -> list[Any]:
    """Setpoints and commands that the companion sent since then, but for those that ask for messages."""
    quiet = (mavlink.MAV_CMD_SET_MESSAGE_INTERVAL, mavlink.MAV_CMD_REQUEST_MESSAGE)
    return [
        message
        for time_s, message in link.sent
        if time_s > since_s
        and (isinstance(message, SETPOINT) or (isinstance(message, COMMAND) and message.command not in quiet))
    ]


def stall(seconds: float, unread_s: float = 0.1) -> Any:
    """The computer is busy for so long; what arrives meanwhile is read `unread_s` after that."""

    def trouble(link: TamperedLink, pilot: Pilot) -> None:
        loop: Any = asyncio.get_running_loop()
        waiting: list[Message] = []

        def read() -> None:
            link.incoming = lambda message: message
            for message in waiting:
                link.say(message)

        link.incoming = waiting.append
        loop.jump(seconds)
        loop.call_later(unread_s, read)

    return trouble


@both
def test_a_busy_computer_reads_what_waits_before_it_misses_telemetry(vehicle: str) -> None:
    link = TamperedLink(vehicle=vehicle)
    _, outcome, error = fly_with(link, stall(0.7))
    assert error is None
    assert outcome is not None
    sent_s = np.array(link.setpoint_times())
    assert 0.75 < np.diff(sent_s).max() < 0.9  # no setpoint on a state that is too old


def test_the_strategy_sees_the_vehicle_as_it_is_now() -> None:
    ages_s: list[float] = []
    moved_m: list[float] = []

    async def scenario() -> None:
        async with connected(TamperedLink("realistic")) as pilot:

            def law(trajectory: Trajectory, time_s: float, state: VehicleState) -> Reference:
                told = pilot.telemetry.state
                assert told is not None
                assert state.time_s == clock.now()
                ages_s.append(state.time_s - told.time_s)
                ahead = told.position + ages_s[-1] * told.velocity
                moved_m.append(float(np.linalg.norm(state.position - ahead)))
                return position_velocity(trajectory, time_s, state)

            await pilot.fly(FlightPlan(straight(), law))

    virtually(scenario())
    assert 0.005 < np.median(ages_s) < 0.1
    assert max(moved_m) < 1e-9


def test_a_computer_that_was_busy_for_too_long_sends_nothing_more() -> None:
    link = TamperedLink(vehicle=PX4)
    began_s: list[float] = []

    def trouble(link: TamperedLink, pilot: Pilot) -> None:
        began_s.append(clock.now())
        stall(1.3, 0.0)(link, pilot)

    _, _, error = fly_with(link, trouble)
    assert isinstance(error, GapError | TakenError)
    assert not asked(link, began_s[0])
    assert link.mode == "POSCTL"


@pytest.mark.parametrize("state_age_s", [0.5, 5.0])
@pytest.mark.parametrize("silent_s", [1.5, 2.5, 20.0])
@both
def test_after_a_gap_in_the_link_nothing_is_sent(vehicle: str, silent_s: float, state_age_s: float) -> None:
    link = TamperedLink(vehicle=vehicle)
    timeout_s = {PX4: 1.0, ARDUPILOT: 3.0}[vehicle]
    began_s: list[float] = []

    def trouble(link: TamperedLink, pilot: Pilot) -> None:
        began_s.append(clock.now())
        link.incoming, link.outgoing = lambda message: None, lambda message: False

        def mended() -> None:
            link.incoming, link.outgoing = lambda message: message, lambda message: True

        asyncio.get_running_loop().call_later(silent_s, mended)

    limits = GuardLimits(watchdogs=Watchdogs(state_age_s=Watchdog(limit=state_age_s)))
    _, _, error = fly_with(link, trouble, plan=FlightPlan(FAR, limits=limits))
    if silent_s < min(timeout_s, state_age_s):
        assert error is None
        return
    assert isinstance(error, TrackingError | GapError)
    assert not asked(link, began_s[0] + max(timeout_s, 1.02))
    if silent_s > timeout_s + 0.2:
        assert link.mode == {PX4: "POSCTL", ARDUPILOT: "OFFBOARD"}[vehicle]


@both
def test_a_pilot_is_noticed_within_a_quarter_of_a_second(vehicle: str) -> None:
    link = TamperedLink("realistic", vehicle)
    taken_s: list[float] = []

    def trouble(link: TamperedLink, pilot: Pilot) -> None:
        taken_s.append(clock.now())
        link.pilot_switches_to(OTHER_MODE[vehicle])

    _, _, error = fly_with(link, trouble, after_s=1.37)
    assert isinstance(error, TakenError)
    assert not asked(link, taken_s[0] + 0.25)


@both
def test_a_flight_that_was_taken_goes_on_where_the_vehicle_is(vehicle: str) -> None:
    link = TamperedLink(vehicle=vehicle)
    plan = FlightPlan(FAR)

    async def scenario() -> tuple[Vec3, float, list[str]]:
        async with connected(link) as pilot:

            def at(text: str) -> None:
                if text.startswith("tracking"):
                    switch = link.pilot_switches_to
                    asyncio.get_running_loop().call_later(6.0, switch, OTHER_MODE[vehicle])

            pilot.on_announce = at
            with pytest.raises(TakenError):
                await pilot.fly(plan)
            pilot.on_announce = lambda text: None
            pilot.announced.clear()
            await asyncio.sleep(4.0)
            here, now_s = link.firmware.estimate.position.copy(), clock.now()
            outcome = await pilot.fly(replace(plan, resume=True))
            assert outcome.accuracy.max_m < 1.0
            return here, now_s, pilot.announced

    here, resumed_s, announced = virtually(scenario())
    assert 1.0 < here[1] < 6.0
    assert announced[0].endswith("resuming where it is")
    sent = [each for time_s, each in link.sent if isinstance(each, SETPOINT) and time_s > resumed_s]
    places = np.array([(each.x, each.y, each.z) for each in sent])
    np.testing.assert_allclose(places[0], here, atol=0.2)
    assert places[:, 1].min() > here[1] - 0.3
    assert places[-1, 1] == pytest.approx(8.0, abs=0.1)
    assert np.linalg.norm(np.diff(places, axis=0), axis=1).max() < 0.06


def test_there_is_nothing_to_resume_on_the_ground() -> None:
    link = TamperedLink()
    _, _, error = fly_with(link, lambda *_: None, plan=FlightPlan(straight(), resume=True))
    assert isinstance(error, FlightError)
    assert "nothing to resume" in str(error)
    assert not asked(link, 0.0)


def test_a_vehicle_that_was_never_ours_is_left_in_its_mode() -> None:
    link = TamperedLink()

    async def scenario() -> None:
        async with connected(link) as pilot:
            await pilot.fly(FlightPlan(straight()))
            link.pilot_switches_to(OTHER_MODE[PX4])
            await asyncio.sleep(1.5)
            link.outgoing = lambda message: not isinstance(message, SETPOINT)
            with pytest.raises(RefusedError, match="no offboard setpoints"):
                await pilot.fly(FlightPlan(straight()))
            await asyncio.sleep(2.0)

    virtually(scenario())
    assert link.mode == "POSCTL"


@pytest.mark.parametrize("after", [After.LAND, After.RETURN])
@both
def test_the_vehicle_is_handed_back_as_asked(vehicle: str, after: After) -> None:
    link = TamperedLink(vehicle=vehicle)
    plan = FlightPlan(straight(end=np.array([3.0, 0.0, -2.0])), after=after)
    pilot, outcome, _ = fly_with(link, lambda *_: None, plan=plan)
    assert outcome is not None
    assert not link.firmware.armed
    north, _, down = link.firmware.estimate.position
    assert down > -0.3
    assert north == pytest.approx({After.LAND: 3.0, After.RETURN: 0.0}[after], abs=0.6)
    assert pilot.announced[-2:] == ["holding", {After.LAND: "landing"}.get(after, pilot.announced[-1])]


def test_the_nose_points_along_the_path() -> None:
    link = TamperedLink()
    _, outcome, _ = fly_with(link, lambda *_: None, plan=FlightPlan(FAR, yaw=YawMode.PATH))
    assert outcome is not None
    yaws = np.unwrap(outcome.recording.references.yaw)
    assert yaws[-1] == pytest.approx(math.pi / 2.0, abs=0.05)
    assert np.abs(np.diff(yaws)).max() <= math.radians(45.0) * 0.02 + 1e-9
    assert outcome.recording.states.attitude[-1, 2] == pytest.approx(math.pi / 2.0, abs=0.1)


@both
def test_a_jump_of_the_estimate_is_no_step_for_the_vehicle(vehicle: str) -> None:
    link = TamperedLink(vehicle=vehicle)
    jump = np.array([0.9, -0.6, 0.8])
    jumped_s: list[float] = []

    def trouble(link: TamperedLink, pilot: Pilot) -> None:
        estimate = link.estimator
        estimate.wander[0] += jump
        estimate.position[:] += jump
        estimate.wander_rate[0] = 1e-9  # it stays
        estimate.resets[0] += 1
        estimate.jump[0] = jump
        jumped_s.append(clock.now())

    _, outcome, _ = fly_with(link, trouble, after_s=8.0, plan=FlightPlan(FAR))
    assert outcome is not None
    assert any("estimate jumped by" in text for _, text in outcome.recording.events)
    states = outcome.recording.states
    soon = (states.time_s > jumped_s[0]) & (states.time_s < jumped_s[0] + 3.0)
    tilt = np.abs(states.attitude[soon, :2]).max()
    assert tilt < math.radians(3.0)  # 12 or more where the setpoint stays behind
    sent = outcome.recording.references
    step = int(np.argmax(sent.time_s > jumped_s[0] + 0.1))
    off = outcome.trajectory.sample(sent.time_s - outcome.start_s).position - sent.position
    np.testing.assert_allclose(off[step], -jump, atol=0.15)
    assert np.linalg.norm(off[-1]) < 0.6 * np.linalg.norm(jump)


@pytest.mark.parametrize("yaw", list(YawMode))
def test_a_jump_of_the_estimated_yaw_is_no_turn_for_the_vehicle(yaw: YawMode) -> None:
    jump = 0.6
    jumped_s: list[float] = []

    def trouble(link: TamperedLink, pilot: Pilot) -> None:
        def jumped(message: Message) -> Message:
            if isinstance(message, mavlink.MAVLink_attitude_message):
                message.yaw += jump
            return message

        link.incoming = jumped
        jumped_s.append(clock.now())

    link = TamperedLink()
    _, outcome, _ = fly_with(link, trouble, after_s=8.0, plan=FlightPlan(FAR, yaw=yaw))
    assert outcome is not None
    assert any("yaw jumped by 0.60 rad" in text for _, text in outcome.recording.events)
    sent = outcome.recording.references
    before, after = (int(np.argmax(sent.time_s > jumped_s[0] + seconds)) for seconds in (-0.05, 0.1))
    assert sent.yaw[after] - sent.yaw[before] == pytest.approx(jump, abs=0.15)


def test_an_estimate_that_jumps_too_far_ends_in_a_hold() -> None:
    def trouble(link: TamperedLink, pilot: Pilot) -> None:
        estimate = link.estimator
        estimate.wander[0] += (4.0, 0.0, 0.0)
        estimate.wander_rate[0] = 1e-9

    link = TamperedLink()
    _, _, error = fly_with(link, trouble)
    assert isinstance(error, TrackingError)
    assert "estimate jumped by 4.0 m" in str(error)
    assert link.mode == "HOLD"
