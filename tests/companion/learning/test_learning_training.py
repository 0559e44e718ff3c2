import sys
from dataclasses import replace
from functools import partial

import numpy as np
import pytest
from lagging_vehicle import LAG_S, STEP_S, LaggingVehicle, flight, sinusoids

from companion.arrays import Array
from companion.errors import InputError
from companion.learning import training
from companion.learning.features import ACCELERATING_OUTPUTS, Preview, inverse_inputs, reference, state_vector
from companion.learning.inverse_network import InverseNetwork
from companion.learning.training import Fit, Progress, estimated_preview, train, train_inverse_network
from companion.learning.training_data import (
    COPIES,
    DISPLACEMENT_M,
    Samples,
    constant_lag,
    displaced,
    plain_lag,
    split,
    training_pairs,
    without_acceleration,
)
from companion.recording.series import Recording, rows
from companion.similarity.axis_loops import axis_loops

PREVIEW = Preview.of_time(0.3)
NOISE = 0.5


@pytest.fixture(scope="module")
def recording() -> Recording:
    return flight(120.0, seed=0)


@pytest.fixture(scope="module")
def network(recording: Recording) -> InverseNetwork:
    return train_inverse_network([recording], PREVIEW, STEP_S, seed=0, lookahead_s=0.42)


def test_pairs_join_what_was_sent_with_where_it_led(recording: Recording) -> None:
    inputs, outputs = training_pairs(recording, PREVIEW, STEP_S)
    ahead = 15  # samples in 0.3 s
    states, sent = recording.states, recording.references
    count = len(states.time_s) - ahead
    assert abs(len(inputs) - count) <= 1
    k = np.arange(len(inputs))
    np.testing.assert_allclose(inputs[:, 0:3], states.position[k + ahead] - states.position[k], atol=1e-9)
    np.testing.assert_allclose(inputs[:, 3:6], states.velocity[k + ahead] - states.velocity[k], atol=1e-9)
    np.testing.assert_allclose(outputs[:, 0:3], sent.position[k] - states.position[k], atol=1e-9)
    np.testing.assert_allclose(outputs[:, 3:6], sent.velocity[k] - states.velocity[k], atol=1e-9)


def test_states_and_references_need_not_share_their_times(recording: Recording) -> None:
    shifted = replace(recording.states, time_s=recording.states.time_s + 0.007)
    inputs, _ = training_pairs(replace(recording, states=shifted), PREVIEW, STEP_S)
    moved, _ = training_pairs(recording, PREVIEW, STEP_S)
    count = min(len(inputs), len(moved)) - 1
    # 7 ms of motion at about 1 m/s between them, and the differences of positions move far less
    np.testing.assert_allclose(inputs[:count, 0:3], moved[1 : count + 1, 0:3], atol=0.03)


def test_two_states_of_one_instant_are_as_good_as_one(recording: Recording) -> None:
    inputs, outputs = training_pairs(recording, PREVIEW, STEP_S)
    count = len(recording.states.time_s)
    for twice in (0, 100, count - 1):
        states = rows(recording.states, np.sort(np.append(np.arange(count), twice)))
        again = training_pairs(replace(recording, states=states), PREVIEW, STEP_S)
        np.testing.assert_array_equal(again.inputs, inputs)
        np.testing.assert_array_equal(again.outputs, outputs)


def test_nothing_is_learned_before_the_first_state_though_there_are_two_of_it(recording: Recording) -> None:
    first = np.array([50, *range(50, len(recording.states.time_s))])
    later = training_pairs(replace(recording, states=rows(recording.states, first)), PREVIEW, STEP_S)
    np.testing.assert_array_equal(later.inputs, training_pairs(recording, PREVIEW, STEP_S).inputs[50:])


def test_each_axis_has_its_own_preview(recording: Recording) -> None:
    preview = Preview(position_s=(0.1, 0.2, 0.3), velocity_s=(0.0, 0.1, 0.2))
    inputs, _ = training_pairs(recording, preview, STEP_S)
    states, k = recording.states, np.arange(len(inputs))
    for axis, (position, velocity) in enumerate([(5, 0), (10, 5), (15, 10)]):
        moved: Array = states.position[k + position, axis] - states.position[k, axis]
        np.testing.assert_allclose(inputs[:, axis], moved, atol=1e-9)
        sped = states.velocity[k + velocity, axis] - states.velocity[k, axis]
        np.testing.assert_allclose(inputs[:, 3 + axis], sped, atol=1e-9)


def test_a_sparser_sampling_takes_a_share(recording: Recording) -> None:
    inputs, _ = training_pairs(recording, PREVIEW, 1 / 7)
    assert len(inputs) == pytest.approx(7 * 119.7, abs=2)


def test_gaps_are_left_out(recording: Recording) -> None:
    time_s = recording.states.time_s
    seen = (time_s < 40.0) | (time_s > 50.0)
    states = recording.states
    holey = replace(
        states,
        time_s=time_s[seen],
        position=states.position[seen],
        velocity=states.velocity[seen],
        attitude=states.attitude[seen],
        rates=states.rates[seen],
    )
    inputs, outputs = training_pairs(replace(recording, states=holey), PREVIEW, STEP_S)
    complete, _ = training_pairs(recording, PREVIEW, STEP_S)
    assert len(complete) - len(inputs) == pytest.approx(10.3 / STEP_S, abs=3)
    assert np.isfinite(inputs).all()
    assert np.isfinite(outputs).all()


def test_a_pause_of_the_references_ends_what_they_led_to(recording: Recording) -> None:
    sent = recording.references
    velocity = sent.velocity.copy()
    velocity[(sent.time_s > 40.0) & (sent.time_s < 50.0)] = np.nan
    inputs, outputs = training_pairs(
        replace(recording, references=replace(sent, velocity=velocity)), PREVIEW, STEP_S
    )
    complete, _ = training_pairs(recording, PREVIEW, STEP_S)
    assert len(complete) - len(inputs) == pytest.approx(10.3 / STEP_S, abs=3)
    assert np.isfinite(outputs).all()


def accelerating(recording: Recording, share: float) -> Recording:
    """The recording, the first `share` of whose references had an acceleration."""
    sent = recording.references
    acceleration = np.random.default_rng(0).normal(size=sent.position.shape)
    acceleration[round(share * len(acceleration)) :] = np.nan
    return replace(recording, references=replace(sent, acceleration=acceleration))


def test_an_acceleration_joins_the_outputs_where_most_references_have_one(recording: Recording) -> None:
    plain_inputs, plain_outputs = training_pairs(recording, PREVIEW, STEP_S)
    most = accelerating(recording, 0.9)
    inputs, outputs = training_pairs(most, PREVIEW, STEP_S)
    count = round(0.9 * len(recording.references.time_s))
    np.testing.assert_array_equal(inputs, plain_inputs[:count])
    np.testing.assert_array_equal(outputs[:, :6], plain_outputs[:count])
    np.testing.assert_array_equal(outputs[:, 6:], most.references.acceleration[:count])
    for without in (accelerating(recording, 0.1), without_acceleration(most)):
        np.testing.assert_array_equal(training_pairs(without, PREVIEW, STEP_S)[1], plain_outputs)


@pytest.mark.parametrize("rows", [0, 1, 2, 100])
def test_too_little_data_is_an_input_error(rows: int) -> None:
    whole = flight(5.0, seed=0)
    states = replace(
        whole.states,
        **{
            name: getattr(whole.states, name)[:rows]
            for name in ("time_s", "position", "velocity", "attitude", "rates")
        },
    )
    with pytest.raises(InputError, match="training samples"):
        training_pairs(replace(whole, states=states), PREVIEW, STEP_S)


def test_the_heading_of_a_flight_does_not_matter() -> None:
    north, _ = training_pairs(flight(10.0, seed=1), PREVIEW, STEP_S)
    west, _ = training_pairs(flight(10.0, seed=1, yaw=2.0), PREVIEW, STEP_S)
    np.testing.assert_allclose(north, west, atol=0.02)


def test_a_displaced_vehicle_is_brought_back_by_the_same_reference(recording: Recording) -> None:
    inputs, outputs = samples = training_pairs(accelerating(recording, 1.0), PREVIEW, STEP_S)
    moved_inputs, moved_outputs = displaced(samples, np.random.default_rng(0))
    beside = moved_inputs[:, 0:3] - np.repeat(inputs[:, 0:3], COPIES, axis=0)
    assert beside.std() == pytest.approx(DISPLACEMENT_M, rel=0.05)
    again = np.repeat(outputs, COPIES, axis=0)
    np.testing.assert_allclose(moved_outputs[:, 0:3] - beside, again[:, 0:3], atol=1e-12)
    np.testing.assert_array_equal(moved_outputs[:, 3:], again[:, 3:])


def test_the_lag_is_found(recording: Recording) -> None:
    states = replace(recording.states, position=sinusoids(recording.states.time_s - 0.42, seed=0)[0])
    assert constant_lag(replace(recording, states=states)) == pytest.approx(0.42, abs=0.006)


def test_the_lag_is_that_of_a_flight_without_acceleration(recording: Recording) -> None:
    assert plain_lag([accelerating(recording, 1.0)]) is None
    assert plain_lag([accelerating(recording, 1.0), recording]) == constant_lag(recording)


def test_the_loop_of_each_axis_is_told_with_intervals_and_gives_a_preview(recording: Recording) -> None:
    loops = axis_loops(recording)
    assert loops is not None
    for loop in loops:
        assert loop.minimum_phase
        assert loop.delay_s < LAG_S
        for value, low, high in (*loop.state_gain, loop.input_gain):
            assert low <= high
            assert value == pytest.approx(0.5 * (low + high), abs=2.0 * (high - low) + 1e-3)
        # Displaced together with its reference, a vehicle flies the same.
        assert loop.state_gain[0][0] + loop.input_gain[0] == pytest.approx(1.0, abs=1e-6)
    preview = estimated_preview(loops)
    assert preview.velocity_s == tuple(
        loop.delay_s + (loop.relative_degree - 1) * loop.step_s for loop in loops
    )
    assert all(LAG_S - 0.05 < lead < 2.0 * LAG_S for lead in preview.velocity_s)


def test_a_flight_too_short_for_a_model_gives_none() -> None:
    assert axis_loops(flight(1.0, seed=0)) is None


def numbered(first: int, count: int) -> Samples:
    inputs = np.arange(first, first + count, dtype=float)[:, None]
    return Samples(inputs, -inputs)


def test_the_last_part_of_each_flight_is_held_out() -> None:
    taught, held_out = split([numbered(0, 100), numbered(1000, 20)])
    np.testing.assert_array_equal(taught.inputs[:, 0], [*range(85), *range(1000, 1017)])
    np.testing.assert_array_equal(held_out.inputs[:, 0], [*range(85, 100), *range(1017, 1020)])
    np.testing.assert_array_equal(held_out.outputs, -held_out.inputs)


@pytest.fixture
def small_networks(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(training, "train", partial(train, hidden_layers=(8,)))


@pytest.mark.usefixtures("small_networks")
def test_a_network_learns_from_several_flights_but_not_across_their_seams(recording: Recording) -> None:
    again = flight(20.0, seed=1)
    network = train_inverse_network([recording, again], PREVIEW, STEP_S, seed=0)
    pairs = [training_pairs(each, PREVIEW, STEP_S) for each in (recording, again)]
    assert network.card.data_flights == 2
    assert network.card.data_seconds == pytest.approx(sum(len(each.inputs) for each in pairs) * STEP_S)


@pytest.mark.usefixtures("small_networks")
def test_only_flights_with_acceleration_teach_where_there_are_any(recording: Recording) -> None:
    with_it = accelerating(flight(20.0, seed=1), 1.0)
    network = train_inverse_network([recording, with_it], PREVIEW, STEP_S, seed=0)
    assert network.card.outputs == ACCELERATING_OUTPUTS
    assert network.card.data_flights == 1


def test_flights_of_two_vehicles_make_no_network(recording: Recording) -> None:
    other = replace(recording, provenance=recording.provenance.model_copy(update={"vehicle": "other"}))
    with pytest.raises(InputError, match="other, spring"):
        train_inverse_network([recording, other], PREVIEW, STEP_S, seed=0)


def linear_problem(seed: int) -> Samples:
    """Samples of a linear map, its outputs (of unit size) with noise."""
    rng = np.random.default_rng(seed)
    inputs = rng.normal(size=(1000, 12))
    outputs = inputs @ rng.normal(scale=12**-0.5, size=(12, 6))
    return Samples(inputs, outputs + rng.normal(scale=NOISE, size=outputs.shape))


def small_fit(seed: int, progress: Progress | None = None) -> Fit:
    return train(*split([linear_problem(0)]), seed=seed, hidden_layers=(64,), progress=progress)


def test_a_linear_map_is_recovered_and_progress_told() -> None:
    told: list[tuple[int, float]] = []
    fit = small_fit(seed=0, progress=lambda steps, error: told.append((steps, error)))
    assert (fit.held_out_rms < 1.3 * NOISE).all()
    assert [steps for steps, _ in told] == sorted({steps for steps, _ in told})
    assert told[-1][1] < told[0][1]


def test_the_same_seed_gives_the_same_bits_and_another_agrees() -> None:
    first, second, other = small_fit(0), small_fit(0), small_fit(1)
    for one, two in zip(first.layers, second.layers, strict=True):
        np.testing.assert_array_equal(one.weight, two.weight)
        np.testing.assert_array_equal(one.bias, two.bias)
    assert not np.array_equal(first.layers[0].weight, other.layers[0].weight)
    np.testing.assert_allclose(first.held_out_rms, other.held_out_rms, rtol=0.1)


def test_without_torch_the_extra_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "torch", None)
    monkeypatch.delitem(sys.modules, "companion.learning.descent", raising=False)
    with pytest.raises(InputError, match=r"impromptu\[train\]"):
        train(*split([linear_problem(0)]), seed=0)


def test_the_card_tells_where_a_network_comes_from(network: InverseNetwork) -> None:
    assert network.card.vehicle == "spring"
    assert network.card.preview == PREVIEW
    assert network.card.data_seconds == pytest.approx(119.7, abs=0.1)
    assert network.card.lookahead_s == 0.42
    assert max(network.card.held_out_rms[:3]) < 0.15


def rms_error(network: InverseNetwork | None) -> float:
    """Tracking error on a motion that the network was not trained on, with it or with the plain reference."""
    time_s = np.arange(0.0, 20.0, STEP_S)
    desired, desired_velocity = sinusoids(time_s, seed=9)
    ahead, ahead_velocity = sinusoids(time_s + PREVIEW.longest_s, seed=9)
    vehicle = LaggingVehicle(desired[0], desired_velocity[0])
    errors = []
    for k in range(len(time_s) - 1):
        u, u_velocity = desired[k], desired_velocity[k]
        if network is not None:
            x = state_vector(vehicle.position, vehicle.velocity, vehicle.attitude(0.0), vehicle.rates(0.0))
            u, u_velocity, _ = reference(x, network(inverse_inputs(x, ahead[k], ahead_velocity[k])))
        vehicle.step(u, u_velocity)
        errors.append(vehicle.position - desired[k + 1])
    return float(np.sqrt(np.mean(np.sum(np.square(errors), axis=1))))


def test_a_trained_network_tracks_what_it_never_saw(network: InverseNetwork) -> None:
    assert rms_error(network) < 0.4 * rms_error(None)
