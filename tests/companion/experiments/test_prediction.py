from dataclasses import replace

import numpy as np
import pytest

from companion.arrays import Times, Vec3s
from companion.errors import InputError
from companion.experiments.prediction import prediction_errors
from companion.learning.online_settings import DEFAULT
from companion.recording import Provenance, Recording, ReferenceSeries, Segment, StateSeries, Window

SEGMENT = Segment("wave", Window(5.0, 20.0))
LAG_S = 0.6


def wave(time_s: Times) -> tuple[Vec3s, Vec3s, Vec3s]:
    angle = np.outer(time_s, (1.0, 1.3, 0.7))
    rate = np.array((1.0, 1.3, 0.7))
    return np.sin(angle), rate * np.cos(angle), -(rate**2) * np.sin(angle)


def recorded(seconds: float = 22.0, noise_m: float = 0.0) -> Recording:
    """A vehicle that is `LAG_S` late; its estimate may be noisy."""
    time_s, sent_s = np.arange(0.0, seconds, 0.01), np.arange(0.003, seconds, 0.02)
    position, velocity, _ = wave(time_s - LAG_S)
    noise = noise_m * np.random.default_rng(0).normal(size=position.shape)
    none = np.zeros_like(position)
    reference, reference_velocity, _ = wave(sent_s)
    return Recording(
        Provenance(vehicle="late"),
        StateSeries(time_s, position + noise, velocity, none, none),
        ReferenceSeries(
            sent_s, reference, reference_velocity, np.full_like(reference, np.nan), np.zeros_like(sent_s)
        ),
    )


def test_the_flight_is_predicted_better_than_by_constant_velocity() -> None:
    errors = prediction_errors(recorded(), SEGMENT, (0.2, 0.36))
    assert list(errors) == [0.2, 0.36]
    for prediction in errors.values():
        assert prediction.gp_rms_m < 0.5 * prediction.constant_velocity_rms_m
        assert prediction.gp_rms_m < 0.2 * prediction.setpoint_rms_m


def test_constant_velocity_and_the_setpoint_of_now() -> None:
    horizon_s, recording = 0.36, recorded()
    prediction = prediction_errors(recording, SEGMENT, (horizon_s,))[horizon_s]
    time_s = np.arange(SEGMENT.window.start_s, SEGMENT.window.end_s - horizon_s, 0.02)
    position, velocity, _ = wave(time_s - LAG_S)
    came = wave(time_s - LAG_S + horizon_s)[0]

    def rms(errors: Vec3s) -> float:
        return float(np.sqrt(np.mean(np.sum(errors**2, axis=1))))

    on = position + horizon_s * velocity
    assert prediction.constant_velocity_rms_m == pytest.approx(rms(came - on), rel=0.01)
    assert prediction.setpoint_rms_m == pytest.approx(rms(came - wave(time_s)[0]), rel=0.03)


def test_before_anything_is_learned_it_is_constant_velocity() -> None:
    start_s = SEGMENT.window.start_s
    brief = Segment("brief", Window(start_s, start_s + 0.38))
    prediction = prediction_errors(recorded(), brief, (0.36,))[0.36]
    assert prediction.gp_rms_m == pytest.approx(prediction.constant_velocity_rms_m)


def test_noise_does_not_make_it_worse_than_constant_velocity() -> None:
    for prediction in prediction_errors(recorded(noise_m=0.03), SEGMENT).values():
        assert prediction.gp_rms_m < 1.05 * prediction.constant_velocity_rms_m


def test_nothing_is_known_before_its_time() -> None:
    recording, jump_s, horizon_s = recorded(), 12.0, 0.36
    states = recording.states
    jumped = np.where(states.time_s[:, None] > jump_s, 100.0, 0.0) + states.position
    until = Segment("until", Window(SEGMENT.window.start_s, jump_s + horizon_s))
    changed = replace(recording, states=replace(states, position=jumped))
    prediction = prediction_errors(changed, until, (horizon_s,))[horizon_s]
    surprised = horizon_s / (until.window.end_s - until.window.start_s - horizon_s)
    assert prediction.gp_rms_m == pytest.approx(np.sqrt(3.0 * surprised) * 100.0, rel=0.05)


def test_setpoints_without_a_position_do_not_count() -> None:
    recording = recorded()
    sent = replace(recording.references, position=np.full_like(recording.references.position, np.nan))
    with pytest.raises(InputError, match="segment wave: no position"):
        prediction_errors(replace(recording, references=sent), SEGMENT, settings=DEFAULT)


def test_a_gap_in_the_telemetry_is_left_out() -> None:
    recording = recorded()
    states = recording.states
    seen = (states.time_s < 10.0) | (states.time_s > 12.0)
    gap = StateSeries(
        *(column[seen] for column in (states.time_s, states.position, states.velocity)),
        *(column[seen] for column in (states.attitude, states.rates)),
    )
    with_gap = prediction_errors(replace(recording, states=gap), SEGMENT, (0.36,))[0.36]
    whole = prediction_errors(recording, SEGMENT, (0.36,))[0.36]
    assert with_gap.constant_velocity_rms_m == pytest.approx(whole.constant_velocity_rms_m, rel=0.2)
    assert with_gap.gp_rms_m < 0.5 * with_gap.constant_velocity_rms_m
