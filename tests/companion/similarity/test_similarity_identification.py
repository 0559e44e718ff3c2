"""Closed loops identified from flights of vehicles that are known."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.linalg import expm
from spring_flight import answering_the_wrong_way, spring_flight

from companion.errors import InputError
from companion.similarity.identification import identify_recording
from companion.similarity.moments import SAMPLE_TIME_S
from companion.similarity.structure import relative_degree_and_delay, structure

PARTS = ("position", "velocity", "acceleration")


def test_a_known_vehicle_is_found() -> None:
    model = identify_recording(spring_flight(), resamples=0)
    A = np.array([[0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [-4.0 / 0.15, -3.2 / 0.15, -1.0 / 0.15]])
    for axis in model.axes[:2]:
        assert axis.model.delay_s == pytest.approx(0.06, abs=0.021)
        assert_allclose(axis.model.reference_weights, (3.2 / 4.0, 1.0 / 4.0), rtol=0.05)
        assert_allclose(axis.model.system.A, expm(A * SAMPLE_TIME_S), atol=0.25)
        assert_allclose(axis.model.system.A[:2, :2], expm(A * SAMPLE_TIME_S)[:2, :2], atol=0.03)
        assert_allclose(axis.model.offset, 0.0, atol=1e-2)


def test_intervals_hold_the_truth_in_spite_of_noise() -> None:
    axis = identify_recording(spring_flight(noise=0.003)).axes[0]
    drawn = np.array([each.reference_weights[0] for each in axis.resamples])
    assert np.min(drawn) < 3.2 / 4.0 < np.max(drawn)
    assert 0.0 < drawn.std() < 0.1


def test_a_displaced_flight_gives_the_same_model() -> None:
    flight = spring_flight()
    there = 40.0
    displaced = replace(
        flight,
        states=replace(flight.states, position=flight.states.position + there),
        references=replace(flight.references, position=flight.references.position + there),
    )
    here, moved = (identify_recording(each, resamples=0).axes[0].model for each in (flight, displaced))
    assert_allclose(moved.system.A, here.system.A, atol=1e-6)
    assert_allclose(moved.system.B, here.system.B, atol=1e-6)


@pytest.mark.parametrize("delay_s", [0.02, 0.1, 0.2])
def test_dead_time_and_relative_degree_come_from_the_data(delay_s: float) -> None:
    flight = spring_flight(delay_s=delay_s)
    north, _, down = relative_degree_and_delay(flight.states, flight.references)
    assert north.delay_s == pytest.approx(delay_s, abs=0.021)
    assert north.relative_degree == down.relative_degree == 2
    assert north.minimum_phase
    assert north.lead_s == pytest.approx(north.delay_s + 2 * SAMPLE_TIME_S)


def test_a_vehicle_that_first_answers_the_wrong_way_is_not_minimum_phase() -> None:
    found = identify_recording(spring_flight(), resamples=0).axes[0].model
    assert structure(found).minimum_phase
    assert not structure(answering_the_wrong_way(found)).minimum_phase


def test_references_without_velocity_and_acceleration_are_enough() -> None:
    flight = spring_flight()
    nothing = np.full_like(flight.references.velocity, np.nan)
    bare = replace(flight, references=replace(flight.references, velocity=nothing, acceleration=nothing))
    axis = identify_recording(bare, resamples=2).axes[0]
    assert_allclose(axis.model.reference_weights, 0.0)


def test_what_lies_in_a_gap_is_left_out() -> None:
    flight = spring_flight()
    kept = (flight.states.time_s < 10.0) | (flight.states.time_s > 20.0)
    states = replace(
        flight.states,
        **{
            name: getattr(flight.states, name)[kept]
            for name in ("time_s", "position", "velocity", "attitude", "rates")
        },
    )
    whole, torn = (identify_recording(each, resamples=0) for each in (flight, replace(flight, states=states)))
    assert torn.seconds == pytest.approx(whole.seconds - 10.0, abs=1.0)
    assert_allclose(torn.axes[0].model.system.A, whole.axes[0].model.system.A, atol=0.05)


def test_an_axis_far_from_its_reference_is_named() -> None:
    flight = spring_flight()
    away = flight.references.position + np.array((0.0, 0.0, 3.0))
    with pytest.raises(InputError, match=r"down: 0\.0 s .* within 2 m"):
        identify_recording(replace(flight, references=replace(flight.references, position=away)))


def test_a_vehicle_at_rest_is_not_identified_from_gusts() -> None:
    flight = spring_flight(noise=0.003)
    still = replace(flight.references, **{name: np.zeros_like(flight.references.position) for name in PARTS})
    at_rest = replace(
        flight, references=still, states=replace(flight.states, position=0.01 * flight.states.position)
    )
    with pytest.raises(InputError, match="reference moved by less than"):
        identify_recording(at_rest, resamples=0)


def test_motion_along_one_axis_is_enough() -> None:
    flight = spring_flight(noise=0.003)
    north_alone = np.array((1.0, 0.0, 0.0))
    states = {name: getattr(flight.states, name) * north_alone for name in ("position", "velocity")}
    sent = {name: getattr(flight.references, name) * north_alone for name in PARTS}
    flown = replace(
        flight, states=replace(flight.states, **states), references=replace(flight.references, **sent)
    )
    north = identify_recording(flown, resamples=0).axes[0]
    assert_allclose(north.model.reference_weights, (0.8, 0.25), rtol=0.1)


def test_velocities_are_not_taken_for_positions() -> None:
    flight = spring_flight()
    nothing = np.full_like(flight.references.position, np.nan)
    velocity_only = replace(flight, references=replace(flight.references, position=nothing))
    with pytest.raises(InputError, match="no position references in this flight: send positions"):
        identify_recording(velocity_only)


def test_an_acceleration_without_a_velocity_keeps_its_place() -> None:
    """The spring is sent its velocity as a displaced position."""
    flight = spring_flight()
    sent = flight.references
    nothing = np.full_like(sent.velocity, np.nan)
    bare = replace(sent, position=sent.position + 0.8 * sent.velocity, velocity=nothing)
    axis = identify_recording(replace(flight, references=bare), resamples=0).axes[0]
    T_v, T_a = axis.model.reference_weights
    assert T_v == 0.0
    assert T_a == pytest.approx(0.25, rel=0.1)


@pytest.mark.parametrize("seconds", [0.04, 0.3, 2.0])
def test_too_short_a_flight_is_refused(seconds: float) -> None:
    with pytest.raises(InputError):
        identify_recording(spring_flight(seconds=seconds))


def test_references_of_the_kind_that_moved_most_count() -> None:
    flight = spring_flight(seconds=60.0)
    sent = flight.references
    late = (sent.time_s > 45.0)[:, None]
    mixed = replace(
        flight,
        references=replace(
            sent,
            velocity=np.where(late, np.nan, sent.velocity),
            acceleration=np.where(late, np.nan, sent.acceleration),
        ),
    )
    model = identify_recording(mixed, resamples=0)
    assert model.seconds == pytest.approx(45.0, abs=1.0)
    assert_allclose(model.axes[0].model.reference_weights, (0.8, 0.25), rtol=0.05)


def test_what_is_held_back_far_from_its_reference_is_left_out() -> None:
    flight = spring_flight()
    sent = flight.references
    away = np.where((sent.time_s < 8.0)[:, None], 50.0, 0.0) + sent.position
    model = identify_recording(replace(flight, references=replace(sent, position=away)), resamples=0)
    assert model.seconds == pytest.approx(40.0 - 8.0, abs=1.0)
    assert_allclose(model.axes[0].model.reference_weights, (0.8, 0.25), rtol=0.05)


def test_a_position_that_moves_beside_its_velocity_is_measured() -> None:
    flight = spring_flight()
    steady = identify_recording(flight, resamples=0)
    pushed = flight.states.position + 0.2 * flight.states.time_s[:, None]
    away = flight.references.position + 0.2 * flight.states.time_s[:, None]
    drifting = identify_recording(
        replace(
            flight,
            states=replace(flight.states, position=pushed),
            references=replace(flight.references, position=away),
        ),
        resamples=0,
    )
    assert steady.axes[1].estimate.drift_m_s < 0.01
    assert drifting.axes[1].estimate.drift_m_s == pytest.approx(0.2, abs=0.01)


def test_same_seed_same_intervals() -> None:
    first, again = (identify_recording(spring_flight(noise=0.003), resamples=3, seed=7) for _ in range(2))
    for one, other in zip(first.axes[0].resamples, again.axes[0].resamples, strict=True):
        assert_allclose(one.system.A, other.system.A, rtol=0.0, atol=0.0)
