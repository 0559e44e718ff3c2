"""A simulated vehicle that flies a recording again."""

from dataclasses import replace

import numpy as np
import pytest
from simulated_recording import BOOT_S, fly

from companion.errors import InputError
from companion.experiments.twin import at_times, fly_twin, motion_at
from companion.recording import Recording, Window
from companion.recording.series import rows
from sitl.estimator_errors import EstimatorErrors, PositionError
from sitl.vehicle import load_vehicle

BEBOP2 = load_vehicle("bebop2")


@pytest.fixture(scope="module")
def recording() -> Recording:
    return fly(BEBOP2, 6.0)


def difference(twin_position: np.ndarray, twin_time_s: np.ndarray, recording: Recording) -> float:
    recorded = at_times(twin_time_s, recording.states.time_s, recording.states.position)
    return float(np.abs(twin_position - recorded).max())


def test_the_same_vehicle_flies_the_same(recording: Recording) -> None:
    twin = fly_twin(BEBOP2, recording, Window(BOOT_S + 0.01, BOOT_S + 5.5))
    assert difference(twin.position, twin.time_s, recording) < 0.01
    assert np.ptp(twin.position[:, 0]) > 1.0


def test_another_vehicle_does_not(recording: Recording) -> None:
    twin = fly_twin(load_vehicle("x500"), recording, Window(BOOT_S + 0.01, BOOT_S + 5.5))
    assert difference(twin.position, twin.time_s, recording) > 0.03


def test_it_begins_where_the_recording_was(recording: Recording) -> None:
    twin = fly_twin(BEBOP2, recording, Window(BOOT_S + 3.0, BOOT_S + 3.1))
    motion = motion_at(recording.states, BOOT_S + 3.0)
    assert twin.position[0] == pytest.approx(motion[:3])
    assert twin.velocity[0] == pytest.approx(motion[3:6])
    assert twin.time_s[[0, -1]] == pytest.approx((BOOT_S + 3.0, BOOT_S + 3.1))


def test_where_the_recording_lies_makes_no_difference(recording: Recording) -> None:
    window = Window(BOOT_S + 1.0, BOOT_S + 2.0)
    shift = np.array((50.0, -20.0, 99.0))
    moved = replace(
        recording,
        states=replace(recording.states, position=recording.states.position + shift),
        references=replace(recording.references, position=recording.references.position + shift),
    )
    assert fly_twin(BEBOP2, moved, window).position == pytest.approx(
        fly_twin(BEBOP2, recording, window).position + shift
    )


def test_noise_only_when_asked_for(recording: Recording) -> None:
    noise = EstimatorErrors(position=PositionError(noise_m=0.1))
    noisy = BEBOP2.model_copy(update={"estimator": noise})
    window = Window(BOOT_S + 1.0, BOOT_S + 2.0)
    quiet = fly_twin(BEBOP2, recording, window).position
    assert fly_twin(noisy, recording, window).position.tobytes() == quiet.tobytes()
    assert np.abs(fly_twin(BEBOP2, recording, window, errors=noise).position - quiet).max() > 0.1


def test_the_heading_between_two_states_goes_the_short_way(recording: Recording) -> None:
    states = rows(recording.states, np.array((0, 1)))
    states = replace(states, attitude=np.array(((0.0, 0.0, 3.1), (0.0, 0.0, -3.1))))
    w, x, y, z = motion_at(states, float(states.time_s.mean()))[6:10]
    assert abs(z) == pytest.approx(1.0)
    assert (w, x, y) == pytest.approx((0.0, 0.0, 0.0))


def test_a_window_needs_a_state_and_a_setpoint_at_its_start(recording: Recording) -> None:
    with pytest.raises(InputError, match="no state"):
        fly_twin(BEBOP2, recording, Window(BOOT_S - 5.0, BOOT_S + 1.0))
    late = replace(recording, references=rows(recording.references, np.arange(100, 200)))
    with pytest.raises(InputError, match="nothing was sent"):
        fly_twin(BEBOP2, late, Window(BOOT_S + 1.0, BOOT_S + 3.0))
