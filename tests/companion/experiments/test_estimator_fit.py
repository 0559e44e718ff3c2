"""Estimator errors, found again in flights that the simulator made with them."""

from dataclasses import replace

import numpy as np
import pytest
from simulated_recording import BOOT_S, HOVER, fly, weave

from companion.arrays import Vec3
from companion.experiments.estimator_fit import Wanted, fit_estimator_errors, wanted_moments
from companion.experiments.wander import hover_of, recorded_wander, simulated_wander
from companion.recording import Provenance, Recording, ReferenceSeries, Segment, Window
from sitl.estimator_errors import EstimatorErrors
from sitl.vehicle import load_vehicle

VEHICLE = load_vehicle("px4_sih")
HOVER_S, FLIGHT_S = 16.0, 160.0
ERRORS = EstimatorErrors.model_validate(
    {
        "position": {"wander_m": [0.02, 0.04, 0.03], "wander_time_s": 10.0},
        "velocity": {"wander_m_s": [0.1, 0.2, 0.1], "wander_time_s": 3.0},
        "rates": {"noise_deg_s": 2.0},
    }
)


def flown(errors: EstimatorErrors, hover_s: float, flight_s: float = 0.0) -> Recording:
    """A hover of which 5 s are left out, then a flight."""
    start_s = 5.0 + hover_s

    def path(time_s: float) -> tuple[Vec3, Vec3]:
        return weave(time_s - start_s) if time_s > start_s else (HOVER[:3], np.zeros(3))

    hovered = Window(BOOT_S + 5.0, BOOT_S + start_s - 0.02)
    segment = Segment("weave", Window(BOOT_S + start_s, BOOT_S + start_s + flight_s - 0.02))
    recording = fly(VEHICLE, start_s + flight_s, path=path, errors=errors)
    return replace(recording, hover=hovered, segments=(segment,) if flight_s else ())


def moments(recording: Recording) -> Wanted:
    return wanted_moments(
        recorded_wander(recording).moments, recording.states, recording.segments, HOVER_S - 0.02
    )


def test_a_twin_with_the_fitted_errors_wanders_as_the_recording() -> None:
    states = hover_of(VEHICLE, ERRORS, 45.0, seed=3)
    none = np.empty((0, 3))
    sent = ReferenceSeries(np.empty(0), none, none, none, np.empty(0))
    recording = Recording(Provenance(vehicle="px4_sih"), states, sent, hover=Window(5.0, 44.98))
    errors = fit_estimator_errors(VEHICLE, recording, (), windows=4)
    recorded = recorded_wander(recording)
    twin = simulated_wander(VEHICLE, errors, 40.0, windows=6, seed=8)
    assert twin.deviation_m == pytest.approx(recorded.deviation_m, rel=0.4)
    ratio = twin.powers[0] / recorded.powers[0]
    assert (ratio > 1 / 3).all()
    assert (ratio < 3.0).all()
    noise = np.broadcast_to(errors.rates.noise_deg_s, 3)
    assert noise == pytest.approx(2.0, rel=0.15)


def test_a_flight_tells_the_velocity_error_of_which_a_short_hover_shows_little() -> None:
    recording = flown(ERRORS, HOVER_S, FLIGHT_S)
    velocity = fit_estimator_errors(VEHICLE, recording, recording.segments, windows=3).velocity
    level = np.hypot(velocity.noise_m_s, velocity.wander_m_s)
    assert level == pytest.approx(ERRORS.velocity.wander_m_s, rel=0.35)


def test_a_mean_over_more_windows_counts_for_more() -> None:
    hovering, flying = moments(flown(ERRORS, HOVER_S)), moments(flown(ERRORS, HOVER_S, FLIGHT_S))
    assert (flying.weights / hovering.weights).tolist() == [1.0, 1.0, 1.0, 10.0]


def test_a_drift_that_comes_from_moving_is_no_wander() -> None:
    late = EstimatorErrors.model_validate(
        {"position": {"delay_s": 0.1}, "velocity": {"wander_m_s": 0.002, "wander_time_s": 1.0}}
    )
    recording = flown(late, HOVER_S, FLIGHT_S)
    hovering, flying = moments(replace(recording, segments=())), moments(recording)
    assert (flying.moments == hovering.moments).all()
    assert (flying.weights == hovering.weights).all()
