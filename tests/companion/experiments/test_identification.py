"""A vehicle's numbers, found again in a flight that the simulator made of it."""

import numpy as np
import pytest
from simulated_recording import BOOT_S, fly

from companion.errors import InputError
from companion.experiments.confidence import confidence_half_widths
from companion.experiments.identification import LEAD_IN_S, SHOT_S, Identification, identify, shots_of
from companion.experiments.vehicle_parameters import parameter, with_values
from companion.recording import Recording, Segment, Window
from sitl.estimator_errors import EstimatorErrors, PositionError, VelocityError
from sitl.vehicle import Vehicle, load_vehicle

BEBOP2 = load_vehicle("bebop2")
TRUE = {"px4_parameters.MPC_XY_P": 1.2, "body_drag.linear_n_s_per_m": 0.015, "rotors.time_constant_s": 0.03}
NOISE = EstimatorErrors(
    position=PositionError(noise_m=0.01, correlation_time_s=0.5),
    velocity=VelocityError(noise_m_s=0.01, correlation_time_s=0.2),
)


def recorded(errors: EstimatorErrors | None = None) -> Recording:
    return fly(with_values(BEBOP2, TRUE), 14.0, errors=errors)


def fitted(recording: Recording, *keys: str, vehicle: Vehicle = BEBOP2) -> Identification:
    shots = shots_of(recording, recording.segments)
    return identify(vehicle, shots, [parameter(vehicle, key) for key in keys], lambda number, rms_m: None)


@pytest.fixture(scope="module")
def found() -> Identification:
    return fitted(recorded(NOISE), *TRUE)


def test_it_finds_the_numbers_that_flew(found: Identification) -> None:
    for estimate, true in zip(found.estimates, TRUE.values(), strict=True):
        assert abs(estimate.value - true) < max(estimate.half_width, 0.02 * true), estimate
        assert not estimate.at_bound
    assert found.estimates[0].identifiable
    assert found.converged


def test_the_twin_comes_closer(found: Identification) -> None:
    assert found.rms_m < 0.3 * found.start_rms_m
    assert found.vehicle.rotors.time_constant_s == found.estimates[2].value


def test_the_same_input_gives_the_same_values() -> None:
    recording = fly(BEBOP2, 9.0, errors=NOISE)
    assert fitted(recording, "mass_kg").estimates == fitted(recording, "mass_kg").estimates


def test_what_does_not_show_is_not_identifiable() -> None:
    recording = fly(BEBOP2, 9.0)
    gain, tilt = fitted(recording, "px4_parameters.MPC_XY_P", "px4_parameters.MPC_TILTMAX_LND").estimates
    assert gain.identifiable
    assert np.isinf(tilt.half_width)
    assert not tilt.identifiable
    with pytest.raises(InputError, match=r"nothing of px4_parameters\.MPC_TILTMAX_LND shows"):
        fitted(recording, "px4_parameters.MPC_TILTMAX_LND")


def test_a_value_beyond_the_bounds_is_told() -> None:
    recording = fly(with_values(BEBOP2, {"px4_parameters.MPC_XY_P": 2.0}), 10.0)
    slow = with_values(BEBOP2, {"px4_parameters.MPC_XY_P": 0.3})
    (gain,) = fitted(recording, "px4_parameters.MPC_XY_P", vehicle=slow).estimates
    assert gain.value == pytest.approx(1.2, rel=0.01)
    assert gain.at_bound


def test_a_trial_that_is_no_vehicle_is_not_followed() -> None:
    """A quarter of the thrust of a Bebop 2 does not carry it, so half of the bounds' width is closed."""
    (thrust,) = fitted(fly(BEBOP2, 9.0), "rotors.thrust_coefficient_n_s2").estimates
    assert thrust.parameter.low < 0.5 * thrust.parameter.start
    assert thrust.value > 0.6 * thrust.parameter.start


def test_long_segments_are_flown_in_stretches_that_count_without_their_lead_in() -> None:
    recording = recorded()
    shots = shots_of(recording, [Segment("all", Window(BOOT_S + 0.1, BOOT_S + 12.0))])
    assert [shot.counted_from_s for shot in shots] == pytest.approx([BOOT_S + 0.1 + LEAD_IN_S])
    shots = shots_of(recording, [Segment("long", Window(BOOT_S, BOOT_S + 2 * SHOT_S + LEAD_IN_S))])
    first, second = shots
    assert first.window.end_s == second.counted_from_s == second.window.start_s + LEAD_IN_S


def test_a_short_segment_is_refused() -> None:
    with pytest.raises(InputError, match=r"segment hop lasts 4\.0 s"):
        shots_of(recorded(), [Segment("hop", Window(BOOT_S, BOOT_S + 4.0))])


def test_intervals_hold_the_truth_as_often_as_they_say() -> None:
    rng = np.random.default_rng(0)
    time = np.linspace(0.0, 20.0, 400)
    jacobian = np.zeros((400, 6, 2))
    jacobian[:, 0, 0], jacobian[:, 1, 1] = np.sin(time), 1.0
    held = []
    for _ in range(200):
        noise = np.zeros((400, 6))
        for row in range(1, 400):
            noise[row] = 0.9 * noise[row - 1] + rng.standard_normal(6)
        matrix, wanted = jacobian.reshape(-1, 2), noise.ravel()
        estimate = np.linalg.lstsq(matrix, wanted)[0]
        residuals = (wanted - matrix @ estimate).reshape(-1, 6)
        held.append(np.abs(estimate) < confidence_half_widths(jacobian, residuals, [200, 200]))
    share = np.mean(held, axis=0)
    assert (share > 0.85).all()
    assert (share < 1.0).all()
