"""What goes wrong in flight ends in a hold, in plain words, and with nothing left running."""

import asyncio
import math
import signal
from typing import Any

import numpy as np
import pytest
from tampered_link import (
    POSCTL,
    PROVENANCE,
    Pilot,
    TamperedLink,
    connected,
    fly_with,
    straight,
    virtually,
    without,
)

from companion import clock
from companion.errors import LinkError, RefusedError, TakenError, TrackingError
from companion.flight.flight import After, FlightPlan
from companion.flight.guard import Clip, GuardLimits
from companion.flight.online_correction import OnlineCorrection, OnlineStep
from companion.flight.reference import Correction, Reference
from companion.flight.strategies import position_velocity
from companion.learning.online_settings import DEFAULT
from companion.link.dialect import Message, mavlink
from companion.state import VehicleState
from companion.trajectory import Trajectory

ARM, SET_MODE = mavlink.MAV_CMD_COMPONENT_ARM_DISARM, mavlink.MAV_CMD_DO_SET_MODE


def not_a_number(message: Message) -> Message:
    if isinstance(message, mavlink.MAVLink_local_position_ned_message):
        message.x = math.nan
    return message


def assert_held(link: TamperedLink, pilot: Pilot) -> None:
    """In a hold because we said so, and with no setpoint after that."""
    assert link.mode == "HOLD"
    assert pilot.announced[-1] == "the vehicle holds"
    assert link.setpoint_times()[-1] <= link.commanded(SET_MODE)[-1] + 0.05


@pytest.mark.parametrize(
    "lost", [mavlink.MAVLink_local_position_ned_message, mavlink.MAVLink_attitude_message]
)
def test_telemetry_that_stops_ends_in_a_hold(lost: type[Message]) -> None:
    link = TamperedLink()
    pilot, _, error = fly_with(link, lambda link, _: setattr(link, "incoming", without(lost)))
    assert isinstance(error, TrackingError)
    assert str(error).startswith("no new position for 0.5 s")
    assert_held(link, pilot)
    assert any("no new position" in text for _, text in pilot.recorder.recording(PROVENANCE).events)


def test_numbers_that_are_none_are_dropped_and_then_missed() -> None:
    link = TamperedLink()
    pilot, _, error = fly_with(link, lambda link, _: setattr(link, "incoming", not_a_number))
    assert isinstance(error, TrackingError)
    assert pilot.telemetry.not_finite > 10
    assert_held(link, pilot)
    assert np.isfinite(pilot.recorder.recording(PROVENANCE).states.position).all()


def test_a_few_numbers_that_are_none_do_no_harm() -> None:
    def trouble(link: TamperedLink, pilot: Pilot) -> None:
        link.incoming = not_a_number
        asyncio.get_running_loop().call_later(0.3, setattr, link, "incoming", lambda message: message)

    pilot, outcome, _ = fly_with(TamperedLink(), trouble)
    assert pilot.telemetry.not_finite > 10
    assert outcome is not None


def test_a_link_that_goes_dead_leaves_the_vehicle_to_its_failsafe() -> None:
    def trouble(link: TamperedLink, pilot: Pilot) -> None:
        link.incoming, link.outgoing = lambda message: None, lambda message: False

    link = TamperedLink()
    pilot, _, error = fly_with(link, trouble)
    assert isinstance(error, TrackingError)
    assert pilot.announced[-1].startswith("could not be told to hold")
    assert link.mode not in ("OFFBOARD", "TAKEOFF")  # after COM_OF_LOSS_T
    assert link.setpoint_times()[-1] < min(link.commanded(SET_MODE)[1:])


def test_a_vehicle_that_drifts_away_is_told_to_hold() -> None:
    def astray(trajectory: Trajectory, time_s: float, state: VehicleState) -> Reference:
        return Reference(state.position + np.array([1.5, 0.0, 0.0]), np.array([1.0, 0.0, 0.0]))

    link = TamperedLink()
    plan = FlightPlan(straight(end=np.array([-2.0, 0.0, -2.0])), astray)
    pilot, _, error = fly_with(link, lambda *_: None, plan=plan)
    assert isinstance(error, TrackingError)
    assert "m from where it should be (limit 3 m)" in str(error)
    assert_held(link, pilot)


@pytest.mark.parametrize("phase", ["taking off", "going", "settling", "tracking", "landing"])
def test_a_pilot_who_takes_the_vehicle_keeps_it(phase: str) -> None:
    link = TamperedLink()
    taken_s: list[float] = []

    def trouble(link: TamperedLink, pilot: Pilot) -> None:
        taken_s.append(clock.now())
        link.pilot_switches_to(POSCTL)

    after_s = 0.5 if phase == "going" else 2.0
    plan = FlightPlan(straight(), after=After.LAND)
    _, _, error = fly_with(link, trouble, phase=phase, after_s=after_s, plan=plan)
    assert isinstance(error, TakenError)
    assert "POSCTL" in str(error)
    assert link.mode == "POSCTL"
    until_heartbeat_s = 1.1
    assert all(time_s < taken_s[0] + until_heartbeat_s for time_s in link.setpoint_times())
    assert all(time_s < taken_s[0] for time_s in link.commanded(SET_MODE))


@pytest.mark.parametrize("phase", ["going", "settling", "tracking"])
def test_cancelling_leaves_a_hold_and_no_task(phase: str) -> None:
    link = TamperedLink()
    pilots: list[Pilot] = []

    async def flight() -> None:
        this_task = asyncio.current_task()
        assert this_task is not None
        async with connected(link) as pilot:
            pilots.append(pilot)

            def announced(text: str) -> None:
                if text.startswith(phase):
                    this_task.cancel()

            pilot.on_announce = announced
            await pilot.fly(FlightPlan(straight()))

    async def scenario() -> None:
        flying = asyncio.create_task(flight())
        with pytest.raises(asyncio.CancelledError):
            await flying
        assert asyncio.all_tasks() == {asyncio.current_task()}

    virtually(scenario())
    assert_held(link, pilots[0])


def test_ctrl_c_leaves_a_hold() -> None:
    signal.signal(signal.SIGINT, signal.default_int_handler)  # tests may run where `&` made them deaf to it
    link = TamperedLink()
    with pytest.raises(KeyboardInterrupt):
        fly_with(link, lambda *_: signal.raise_signal(signal.SIGINT))
    assert link.mode == "HOLD"
    assert link.setpoint_times()[-1] <= link.commanded(SET_MODE)[-1] + 0.05


def test_a_task_that_fails_leaves_a_hold_and_no_task() -> None:
    async def failing() -> None:
        raise ZeroDivisionError("a fault of ours")

    async def flight() -> None:
        async with connected(link) as pilot:

            def announced(text: str) -> None:
                if text.startswith("tracking"):
                    pilot.connection.spawn(failing())

            pilot.on_announce = announced
            await pilot.fly(FlightPlan(straight()))

    async def scenario() -> None:
        with pytest.raises(ZeroDivisionError, match="a fault of ours"):
            await flight()
        assert asyncio.all_tasks() == {asyncio.current_task()}

    link = TamperedLink()
    virtually(scenario())
    assert link.mode == "HOLD"


def test_a_strategy_that_fails_leaves_a_hold() -> None:
    def failing(trajectory: Trajectory, time_s: float, state: VehicleState) -> Reference:
        if time_s > 1.0:
            raise ZeroDivisionError("a fault of ours")
        return position_velocity(trajectory, time_s, state)

    link = TamperedLink()
    with pytest.raises(ZeroDivisionError):
        fly_with(link, lambda *_: None, plan=FlightPlan(straight(), failing))
    assert link.mode == "HOLD"


def test_a_strategy_that_fails_as_the_pilot_takes_over_leaves_the_vehicle_to_the_pilot() -> None:
    link = TamperedLink()

    def failing(trajectory: Trajectory, time_s: float, state: VehicleState) -> Reference:
        if time_s > 1.0:
            link.say(mavlink.MAVLink_current_mode_message(0, POSCTL[0] << 16, POSCTL[0] << 16))
            raise ZeroDivisionError("a fault of ours")
        return position_velocity(trajectory, time_s, state)

    with pytest.raises(ZeroDivisionError):
        fly_with(link, lambda *_: None, plan=FlightPlan(straight(), failing))
    assert max(link.commanded(SET_MODE)) < link.setpoint_times()[-1]


def test_a_reference_that_is_no_number_falls_back_to_the_baseline() -> None:
    def now_and_then(trajectory: Trajectory, time_s: float, state: VehicleState) -> Reference:
        plain = position_velocity(trajectory, time_s, state)
        tracking = trajectory.name == straight().name and 1.01 < time_s < 1.99
        return Reference(plain.position * math.nan, plain.velocity) if tracking else plain

    _, outcome, _ = fly_with(TamperedLink(), lambda *_: None, plan=FlightPlan(straight(), now_and_then))
    assert outcome is not None
    assert outcome.clips == {Clip.NOT_FINITE: 49}
    assert np.isfinite(outcome.recording.references.position).all()
    assert outcome.accuracy.max_m < 1.0


def test_a_prediction_that_is_no_number_falls_back_to_the_baseline() -> None:
    class Astray(OnlineCorrection):
        def correct(self, *args: Any) -> OnlineStep:
            step = super().correct(*args)
            if args[1].name != straight().name or not 1.01 < args[2] < 1.99:
                return step
            return OnlineStep(Correction(np.full(3, math.inf)), step.predicted, step.alpha)

    plan = FlightPlan(straight(), correction=Astray(DEFAULT))
    _, outcome, _ = fly_with(TamperedLink(), lambda *_: None, plan=plan)
    assert outcome is not None
    assert outcome.clips[Clip.NOT_FINITE] == 49
    assert np.isfinite(outcome.recording.references.position).all()


class NotReady:
    """Answers every arming before `ready_s` with a refusal and its reason, in the vehicle's stead."""

    def __init__(self, link: TamperedLink, ready_s: float) -> None:
        self._link = link
        self._ready_s = ready_s

    def __call__(self, message: Any) -> bool:
        arming = isinstance(message, mavlink.MAVLink_command_long_message) and message.command == ARM
        if not arming or clock.now() >= self._ready_s:
            return True
        result = mavlink.MAV_RESULT_TEMPORARILY_REJECTED
        answers = (
            mavlink.MAVLink_command_ack_message(ARM, result),
            mavlink.MAVLink_statustext_message(mavlink.MAV_SEVERITY_CRITICAL, b"Preflight Fail: no position"),
        )
        for answer in answers:
            asyncio.get_running_loop().call_soon(self._link.say, answer)
        return False


def test_a_vehicle_that_is_not_ready_is_waited_for() -> None:
    link = TamperedLink()
    link.outgoing = NotReady(link, ready_s=20.0)
    pilot, outcome, _ = fly_with(link, lambda *_: None)
    assert outcome is not None
    (told,) = [text for text in pilot.announced if text.startswith("not ready")]
    assert "Preflight Fail: no position" in told


def test_a_vehicle_that_never_gets_ready_says_why() -> None:
    link = TamperedLink()
    link.outgoing = NotReady(link, ready_s=math.inf)
    pilot, _, error = fly_with(link, lambda *_: None)
    assert isinstance(error, RefusedError)
    assert "Preflight Fail: no position" in str(error)
    assert 58.0 < link.commanded(ARM)[-1] < 62.0
    assert not link.commanded(SET_MODE)  # a vehicle on the ground needs no hold
    assert pilot.announced[-1].startswith("not ready")


def test_a_vehicle_without_a_position_is_waited_for_and_then_told() -> None:
    link = TamperedLink()
    link.incoming = without(mavlink.MAVLink_local_position_ned_message)
    pilot, _, error = fly_with(link, lambda *_: None)
    assert isinstance(error, LinkError)
    assert "its estimator is ready" in str(error)
    assert pilot.announced == ["waiting until the vehicle knows its position"]


def test_a_vehicle_that_does_not_tell_whether_it_flies_is_not_sent_up() -> None:
    link = TamperedLink()
    link.incoming = without(mavlink.MAVLink_extended_sys_state_message)
    _, _, error = fly_with(link, lambda *_: None)
    assert error is not None
    assert "whether it flies" in str(error)
    assert not link.commanded(ARM)


def test_the_fence_holds_back_what_would_leave_it() -> None:
    limits = GuardLimits.model_validate({"fence": {"north_m": [-1.0, 1.0]}})
    _, outcome, _ = fly_with(TamperedLink(), lambda *_: None, plan=FlightPlan(straight(), limits=limits))
    assert outcome is not None
    assert outcome.clips[Clip.FENCE] > 0
    assert outcome.recording.references.position[:, 0].max() == pytest.approx(1.0, abs=0.01)


def test_a_vehicle_that_disarms_in_its_climb_is_not_waited_for() -> None:
    link = TamperedLink()
    _, _, error = fly_with(link, lambda link, _: link.simulated.reboot(), phase="taking off", after_s=3.0)
    assert error is not None
    assert "disarmed in its takeoff" in str(error)
    assert not link.setpoint_times()


def test_a_low_ceiling_lowers_the_takeoff() -> None:
    limits = GuardLimits.model_validate({"fence": {"altitude_m": [0.5, 1.5]}})
    low = straight(np.array([0.0, 0.0, -1.2]), np.array([1.0, 0.0, -1.2]))
    pilot, outcome, _ = fly_with(TamperedLink(), lambda *_: None, plan=FlightPlan(low, limits=limits))
    assert "taking off to 1.5 m" in pilot.announced
    assert outcome is not None
    assert -outcome.recording.states.position[:, 2].min() < 1.8
