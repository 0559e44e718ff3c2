"""The guard against negative transfer, in steps and in simulated flights."""

from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np
import pytest

from companion import bundled
from companion.arrays import Vec3
from companion.autopilot.position_loop import loop_of
from companion.experiments.simulated_flights import Scenario, simulate
from companion.experiments.trajectories import limits_within, named_trajectories
from companion.flight.approach import rest_at, rest_to_rest
from companion.flight.control import Control, ControlSettings
from companion.flight.flight import FlightOutcome
from companion.flight.guard import GuardLimits
from companion.flight.heading import YawMode
from companion.flight.online_correction import OnlineCorrection
from companion.flight.recorder import Recorder
from companion.flight.reference import Reference
from companion.flight.strategies import ReferenceLaw, Strategy, position_velocity_acceleration
from companion.flight.supervision import Supervision
from companion.flight.tracker import Tracker
from companion.learning.error_prediction import PredictedError, Step
from companion.learning.inverse_network import InverseNetwork, Scaling
from companion.learning.model_file import load_model
from companion.learning.motion_model import MotionModel
from companion.learning.online_settings import DEFAULT
from companion.recording import topics
from companion.recording.topics import Fields
from companion.state import VehicleState
from companion.trajectory.placement import Placement
from companion.trajectory.trajectory import Trajectory

LINE = rest_to_rest(np.zeros(3), np.array((2.0, 0.0, -1.0)), "line")
STATE = VehicleState(0.0, 0.0, *np.zeros((4, 3)))
LOOP = loop_of((0.95, 1.0, 1.8, 4.0))


def thrown(offset: Vec3, trajectory: Trajectory, time_s: float, state: VehicleState) -> Reference:
    desired = trajectory.at(time_s)
    return Reference(desired.position + offset, desired.velocity, desired.acceleration)


def u1_of(offset: Vec3) -> tuple[Reference, Reference]:
    """The plain reference, and that with a network which adds `offset` to it (m)."""
    supervision = Supervision(
        DEFAULT, {"wrong": lambda trajectory, time_s, state: thrown(offset, trajectory, time_s, state)}
    )
    plain = position_velocity_acceleration(LINE, 0.7, STATE)
    return plain, supervision.u1(plain, LINE, 0.7, STATE, LOOP)


def test_a_network_that_throws_the_setpoint_by_metres_is_held_near_the_plain_reference() -> None:
    plain, u1 = u1_of(np.array((5.0, -3.0, 0.0)))
    moved = float(np.linalg.norm(u1.position - plain.position))
    assert 0.0 < moved <= 0.1


def test_a_network_that_answers_no_numbers_is_not_followed() -> None:
    plain, u1 = u1_of(np.array((np.nan, 0.0, 0.0)))
    np.testing.assert_array_equal(u1.position, plain.position)


def test_a_network_that_answers_no_numbers_is_left_out_aloud_once_and_so_is_its_return() -> None:
    answers = {
        "broken": [*np.full(3, np.nan), *np.zeros(20), np.inf, *np.zeros(60)],
        "sound": [*np.zeros(200)],
    }
    step = 0

    def law_of(name: str) -> ReferenceLaw:
        return lambda trajectory, time_s, state: thrown(
            np.array((answers[name][step // 2], 0.0, 0.0)), trajectory, time_s, state
        )

    supervision = Supervision(DEFAULT, {name: law_of(name) for name in answers})
    plain = position_velocity_acceleration(LINE, 0.7, STATE)
    said = {}
    for step in range(2 * len(answers["broken"])):
        u1 = supervision.u1(plain, LINE, 0.7, STATE, LOOP)
        assert u1.is_finite()
        for remark in supervision.remarks():
            said[step // 2] = remark
    assert said == {
        0: "the answer of the network of broken is not finite and is left out",
        73: "the answer of the network of broken is finite again",
    }


class Kinds:
    """A sink that keeps the kinds of events, by their texts."""

    def __init__(self) -> None:
        self.of: dict[str, str] = {}

    def add(self, topic: str, time_s: float, fields: Fields) -> None:
        if topic == topics.EVENTS:
            self.of[fields["message"]] = fields["name"]

    def add_metadata(self, name: str, values: dict[str, Any]) -> None:
        pass

    def attach(self, name: str, data: bytes) -> None:
        pass


def test_what_changes_in_what_is_flown_is_an_event_of_its_own_kind() -> None:
    supervision = Supervision(DEFAULT, {"broken": partial(thrown, np.full(3, np.nan))})
    tracker = Tracker(LINE, 0.0, position_velocity_acceleration, OnlineCorrection(DEFAULT), supervision)
    settings = ControlSettings(
        home=(0.0, 0.0, 0.0), yaw=0.0, yaw_mode=YawMode.HOLD, period_s=0.02, limits=GuardLimits()
    )
    kinds, announced = Kinds(), list[str]()
    control = Control(settings, tracker, Recorder(kinds), announced.append)
    control.setpoint(0.0, STATE)
    remark = "the answer of the network of broken is not finite and is left out"
    assert announced == [remark]
    assert kinds.of[remark] == "learning"


def drawing(vehicle: str) -> Trajectory:
    (trajectory,) = named_trajectories(["Leaf_1"], Placement(), limits_within([vehicle], None))
    return trajectory


def network_of(vehicle: str, factor: float) -> InverseNetwork:
    """That of a vehicle, its answers multiplied by `factor`."""
    network = load_model(bundled.find("models", vehicle, ".safetensors"))
    scaling = Scaling(*(np.float32(factor) * part for part in network.output_scaling))
    return replace(network, output_scaling=scaling)


def rms_m(scenario: Scenario) -> tuple[float, FlightOutcome]:
    outcome, _, _ = simulate(scenario)
    return outcome.accuracy.rms_m, outcome


def said(outcome: FlightOutcome) -> list[str]:
    return [text for _, text in outcome.recording.events if "network" in text or "correction" in text]


def test_a_network_of_the_wrong_sign_is_faded_out_and_it_is_said() -> None:
    gp = Scenario(drawing("bebop2"), Strategy.GP, conditions="windy")
    without_m, _ = rms_m(gp)
    wrong = replace(gp, strategy=Strategy.DNN_GP, network=network_of("ardrone2", -3.0))
    with_m, outcome = rms_m(wrong)
    assert with_m <= max(1.03 * without_m, without_m + 0.005)
    assert "negative transfer: the network did harm and is faded out" in said(outcome)
    tracking = outcome.recording.tracking
    assert tracking is not None
    judged = np.isfinite(tracking.network_share)
    flown = tracking.network_share[judged]
    assert flown[0] == pytest.approx(0.3, abs=0.05)
    assert flown.min() < 0.02
    assert ((flown >= 0.0) & (flown <= 1.0)).all()
    assert (tracking.correction_share[judged] == 1.0).all()


@pytest.fixture
def wrong_model(monkeypatch: pytest.MonkeyPatch) -> None:
    """Predictions of the wrong sign."""
    right = MotionModel.predict

    def wrong(self: MotionModel, step: Step) -> PredictedError:
        predicted = right(self, step)
        return replace(predicted, error=-predicted.error, velocity_error=-predicted.velocity_error)

    monkeypatch.setattr(MotionModel, "predict", wrong)


@pytest.mark.parametrize(("vehicle", "conditions"), [("bebop2", "windy"), ("px4_sih", "px4")])
@pytest.mark.usefixtures("wrong_model")
def test_an_online_model_of_the_wrong_sign_leaves_the_plain_reference(vehicle: str, conditions: str) -> None:
    baseline = Scenario(drawing(vehicle), Strategy.BASELINE, vehicle=vehicle, conditions=conditions)
    without_m, _ = rms_m(baseline)
    with_m, outcome = rms_m(replace(baseline, strategy=Strategy.GP))
    assert with_m <= 1.05 * without_m
    assert said(outcome) == ["negative transfer: the online correction does harm and is faded out"]
    tracking = outcome.recording.tracking
    assert tracking is not None
    assert np.nan_to_num(tracking.correction_share[-1]) == 0.0  # none is left, or a watchdog took it away


def test_resting_tells_nothing_of_a_network() -> None:
    supervision = Supervision(DEFAULT, {"wrong": position_velocity_acceleration})
    at = rest_at(np.zeros(3))
    for k in range(500):
        state = replace(STATE, time_s=0.02 * k, position=np.array((0.1, 0.0, 0.0)))
        supervision.u1(position_velocity_acceleration(at, 0.0, state), at, 0.0, state, LOOP)
    assert supervision.shares.network == pytest.approx(0.3)
    assert supervision.remarks() == []
