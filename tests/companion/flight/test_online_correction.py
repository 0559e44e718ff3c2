"""The online module on a vehicle that moves as told, late and too little."""

from dataclasses import replace

import numpy as np
import pytest

from companion.arrays import Vec3
from companion.autopilot.position_loop import PositionLoop
from companion.flight.online_correction import OnlineCorrection, within_pull
from companion.flight.preview import desired_ahead
from companion.flight.reference import Correction, Reference
from companion.flight.strategies import position_velocity
from companion.flight.tracker import Tracker
from companion.learning.correction import ConstantGain
from companion.learning.features import Preview
from companion.learning.online_settings import DEFAULT, PAPER, OnlineSettings
from companion.state import VehicleState
from companion.trajectory.trajectory import Trajectory, trajectory_of

STEP_S = 0.02
LAG_S = 0.5


def _wave(duration_s: float = 20.0) -> Trajectory:
    def motion(time_s: Vec3) -> tuple[Vec3, Vec3, Vec3]:
        angle = np.outer(time_s, [1.0, 1.3, 0.7])
        rate = np.array([1.0, 1.3, 0.7])
        return 0.5 * np.sin(angle), 0.5 * rate * np.cos(angle), -0.5 * rate**2 * np.sin(angle)

    return trajectory_of("wave", duration_s, motion)


def _state(time_s: float, position: Vec3, velocity: Vec3) -> VehicleState:
    return VehicleState(time_s, time_s, position, velocity, np.zeros(3), np.zeros(3))


def _rms(correction: OnlineCorrection | None) -> float:
    """Tracking error (m) of a vehicle whose velocity follows the reference with a first-order lag."""
    trajectory = _wave()
    tracker = Tracker(trajectory, 0.0, position_velocity, correction)
    position, velocity = trajectory.at(0.0).position.copy(), np.zeros(3)
    squares = []
    for k in range(int(trajectory.duration_s / STEP_S)):
        state = _state(k * STEP_S, position.copy(), velocity.copy())
        tracker.observe(state)
        step = tracker.step(state)
        sent = step.u1.corrected(step.u2)
        tracker.sent(sent, state)
        squares.append(np.sum((position - step.desired.position) ** 2))
        wanted = (sent.position - position) + 0.6 * sent.velocity
        velocity += STEP_S / LAG_S * (wanted - velocity)
        position += STEP_S * velocity
    return float(np.sqrt(np.mean(squares)))


SQUARED_EXPONENTIAL = {
    "corrected": "error",
    "window": 100,
    "kernel": PAPER.kernel,
    "preview": Preview.of_time(0.1),
    "gain": ConstantGain(alpha=(4.0, 4.0, 4.0)),
}


def test_the_correction_takes_away_most_of_the_error() -> None:
    assert _rms(OnlineCorrection(DEFAULT)) < 0.2 * _rms(None)


@pytest.mark.parametrize("form", ["error", "position", "displacement"])
def test_every_form_helps(form: str) -> None:
    settings = OnlineSettings.model_validate(DEFAULT.model_dump() | SQUARED_EXPONENTIAL | {"form": form})
    assert _rms(OnlineCorrection(settings)) < 0.6 * _rms(None)


def test_nothing_is_corrected_before_anything_is_known() -> None:
    correction, trajectory = OnlineCorrection(PAPER), _wave()
    state = _state(0.0, np.zeros(3), np.zeros(3))
    online = correction.correct(Reference(np.ones(3), np.zeros(3)), trajectory, 0.0, state)
    np.testing.assert_array_equal(online.u2.position, np.zeros(3))
    np.testing.assert_array_equal(online.u2.velocity, np.zeros(3))


def test_the_correction_keeps_to_its_length() -> None:
    short = OnlineCorrection(DEFAULT.model_copy(update={"longest_m": 0.01, "velocity": "uncorrected"}))
    trajectory, longest_m = _wave(), 0.0
    for k in range(200):
        state = _state(k * STEP_S, np.array((0.3, 0.0, 0.0)), np.zeros(3))
        short.observe(state)
        u1 = Reference(trajectory.at(k * STEP_S).position, np.zeros(3))
        u2 = short.correct(u1, trajectory, k * STEP_S, state).u2.position
        short.sent(u1, trajectory, k * STEP_S, state)
        longest_m = max(longest_m, float(np.linalg.norm(u2)))
    assert longest_m == pytest.approx(0.01)


def test_a_late_link_bears_less_correction() -> None:
    trajectory = _wave()
    u1 = Reference(np.zeros(3), np.zeros(3))

    def gain(lateness_s: float) -> Vec3:
        correction = OnlineCorrection(DEFAULT)
        for k in range(1000):
            state = replace(_state(0.01 * k, np.zeros(3), np.zeros(3)), received_s=0.01 * k + lateness_s)
            correction.observe(state)
            correction.sent(u1, trajectory, state.time_s, state)
        return correction.correct(u1, trajectory, state.time_s, state).alpha

    np.testing.assert_array_equal(gain(0.02), gain(0.0))
    np.testing.assert_allclose(gain(0.08), gain(0.0) / 4.0, rtol=1e-3)


def test_what_was_sent_is_predicted_by_what_it_led_to() -> None:
    correction, trajectory = OnlineCorrection(DEFAULT), _wave()
    expected, came = [], []
    for k in range(400):
        at = trajectory.at(k * STEP_S)
        state = _state(k * STEP_S, at.position, at.velocity)
        correction.observe(state)
        expected.append(correction.sent(Reference(*at), trajectory, state.time_s, state).position)
        came.append(trajectory.at(k * STEP_S + DEFAULT.preview.longest_s).position)
    errors = np.linalg.norm(np.array(expected) - came, axis=1)
    assert errors[200:].max() < 0.1 * errors[:5].max()


def test_the_autopilot_is_asked_for_as_much_less_as_the_estimate_drifts() -> None:
    correction, trajectory, drift = OnlineCorrection(DEFAULT), _wave(), np.array((0.4, -0.3, 0.0))
    for k in range(500):
        at = trajectory.at(k * STEP_S)
        state = _state(k * STEP_S, at.position, at.velocity - drift)
        correction.observe(state)
        u1 = Reference(*at)
        online = correction.correct(u1, trajectory, state.time_s, state)
        correction.sent(u1, trajectory, state.time_s, state)
    np.testing.assert_allclose(online.u2.velocity, -drift, atol=0.03)


def test_what_is_held_against_a_load_is_kept_from_the_model() -> None:
    """A vehicle that hangs 2 cm low: only the integral answers, and the model learns nothing of it."""
    correction, trajectory, low = OnlineCorrection(DEFAULT), _wave(), np.array((0.0, 0.0, 0.02))
    plain = OnlineCorrection(DEFAULT.model_copy(update={"vertical_integral_1_s": 0.0}))
    for k in range(500):
        at = trajectory.at(k * STEP_S)
        state, u1 = _state(k * STEP_S, at.position + low, at.velocity), Reference(*at)
        online = [each.correct(u1, trajectory, state.time_s, state) for each in (correction, plain)]
        for each, step in zip((correction, plain), online, strict=True):
            each.observe(state)
            each.sent(u1.corrected(step.u2), trajectory, state.time_s, state)
    held, not_held = (step.u2.position for step in online)
    np.testing.assert_allclose(held - not_held, (0.0, 0.0, held[2] - not_held[2]), atol=1e-9)
    assert held[2] < not_held[2] - 0.1
    np.testing.assert_allclose(online[0].predicted.position, online[1].predicted.position, atol=1e-6)


def test_what_is_not_flown_is_not_gathered() -> None:
    correction, trajectory, low = OnlineCorrection(DEFAULT), _wave(), np.array((0.0, 0.0, 0.02))
    for k in range(300):
        at = trajectory.at(k * STEP_S)
        state, u1 = _state(k * STEP_S, at.position + low, at.velocity), Reference(*at)
        correction.observe(state)
        correction.correct(u1, trajectory, state.time_s, state)
        correction.sent(u1, trajectory, state.time_s, state, flown_share=0.0)
    assert abs(correction._vertical.offset_m) < 1e-4


def test_what_is_under_way_is_reckoned_with() -> None:
    """Corrections that come as a surprise, and act 0.1 s late."""
    settings = DEFAULT.model_copy(update={"vertical_integral_1_s": 0.0})
    correction, trajectory, rng = OnlineCorrection(settings), _wave(), np.random.default_rng(0)
    stiffness = correction.loop.stiffness_1_s2
    pushes = 0.1 * rng.choice((-1.0, 1.0), size=(60, 3)).repeat(10, axis=0)
    aside, speed = np.zeros(3), np.zeros(3)
    expected, flown = [], []
    for k, push in enumerate(pushes):
        at = trajectory.at(k * STEP_S)
        state = _state(k * STEP_S, at.position + aside, at.velocity + speed)
        correction.observe(state)
        u1 = Reference(*at)
        correction.correct(u1, trajectory, state.time_s, state)
        sent = u1.corrected(Correction(push, np.zeros(3)))
        expected.append(correction.sent(sent, trajectory, state.time_s, state).position)
        flown.append(state.position)
        speed = 0.95 * speed + STEP_S * stiffness * pushes[max(k - 5, 0)]
        aside = 0.95 * aside + STEP_S * speed
    ahead = round(DEFAULT.preview.longest_s / STEP_S)
    errors = np.array(expected[300:-ahead]) - np.array(flown[300 + ahead :])
    assert np.sqrt(np.mean(errors**2)) < 0.002


def test_each_axis_is_desired_at_its_own_lead() -> None:
    trajectory = _wave()
    preview = Preview(position_s=(0.1, 0.2, 0.3), velocity_s=(0.0, 0.4, 0.5))
    position, velocity = desired_ahead(trajectory, 2.0, preview)
    for axis in range(3):
        assert position[axis] == trajectory.at(2.0 + preview.position_s[axis]).position[axis]
        assert velocity[axis] == trajectory.at(2.0 + preview.velocity_s[axis]).velocity[axis]


@pytest.mark.parametrize("jumps", [True, False])
def test_nothing_is_learned_across_a_jump_of_the_estimate(jumps: bool) -> None:
    correction, trajectory = OnlineCorrection(DEFAULT), _wave()
    tracker = Tracker(trajectory, 0.0, position_velocity, correction)
    for k in range(200):
        desired = trajectory.at(k * STEP_S)
        state = _state(k * STEP_S, desired.position, desired.velocity)
        tracker.observe(state)
        if k < 100:
            tracker.sent(tracker.step(state).u1, state)
        if k == 99:
            learned = len(correction._model)
            if jumps:
                tracker.forget_motion()
    assert learned > 0
    assert (len(correction._model) == learned) is jumps


@pytest.mark.parametrize("times", [0.1, 1.0, 1.9, 2.1, 30.0])
def test_a_correction_pulls_sideways_no_harder_than_it_may(times: float) -> None:
    loop = PositionLoop(np.array([3.0, 3.0, 5.0]), np.array([2.0, 2.0, 2.0]))
    asked = Correction(times * np.array([0.2, 0.0, 0.3]), times * np.array([0.0, 0.4, -0.1]))
    pull = asked.pull(*loop)
    limited = within_pull(asked, loop, 2.0).pull(*loop)
    hardest = min(np.hypot(*pull[:2]), 2.0)
    np.testing.assert_allclose(limited[:2], hardest * pull[:2] / np.hypot(*pull[:2]))
    assert limited[2] == pull[2]
