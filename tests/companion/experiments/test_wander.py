"""How an estimate wanders in hover."""

import numpy as np
import pytest

from companion.errors import InputError
from companion.experiments.wander import (
    OCTAVES_HZ,
    compare_wander,
    hover_of,
    recorded_wander,
    simulated_wander,
)
from companion.recording import Recording, Window
from companion.recording.series import Provenance, ReferenceSeries
from sitl.estimator_errors import EstimatorErrors
from sitl.vehicle import load_vehicle

VEHICLE = load_vehicle("px4_sih")
ERRORS = EstimatorErrors.model_validate(
    {
        "position": {"wander_m": [0.02, 0.04, 0.03], "wander_time_s": 10.0},
        "velocity": {"wander_m_s": [0.1, 0.2, 0.1], "wander_time_s": 3.0},
        "rates": {"noise_deg_s": 2.0},
    }
)
NONE = np.empty((0, 3))
NOTHING_SENT = ReferenceSeries(np.empty(0), NONE, NONE, NONE, np.empty(0))


def hover(errors: EstimatorErrors, seed: int, window_s: float = 16.0) -> Recording:
    states = hover_of(VEHICLE, errors, 5.0 + window_s, seed)
    return Recording(
        Provenance(vehicle="px4_sih"), states, NOTHING_SENT, hover=Window(5.0, 5.0 + window_s - 0.02)
    )


def test_without_errors_nothing_wanders() -> None:
    wander = simulated_wander(VEHICLE, EstimatorErrors(), 16.0, windows=1)
    assert wander.deviation_m.max() < 1e-6
    assert wander.powers.max() < 1e-9


def test_octaves_hold_the_power_of_an_oscillation() -> None:
    flown = hover(EstimatorErrors(), 0)
    time_s = flown.states.time_s
    flown.states.position[:, 1] += 0.3 * np.sin(2.0 * np.pi * 0.5 * time_s)
    wander = recorded_wander(flown)
    octave = OCTAVES_HZ.index((0.4, 0.8))
    assert wander.powers[0, 1, octave] == pytest.approx(0.3**2 / 2.0, rel=0.05)
    assert wander.powers[0, 1].sum() == pytest.approx(wander.powers[0, 1, octave], rel=0.05)
    assert wander.deviation_m == pytest.approx((0.0, 0.3 / np.sqrt(2.0), 0.0), abs=0.005)


def test_the_heading_does_not_matter() -> None:
    flown = hover(EstimatorErrors(), 0)
    wave = 0.3 * np.sin(np.pi * flown.states.time_s)
    flown.states.attitude[:, 2] = np.radians(90.0)
    flown.states.position[:, 1] += wave  # forwards, as the nose points east
    assert recorded_wander(flown).deviation_m == pytest.approx((0.3 / np.sqrt(2.0), 0.0, 0.0), abs=0.005)


def test_a_recording_without_hover_says_what_to_do() -> None:
    with pytest.raises(InputError, match="no hover of 10 s"):
        recorded_wander(hover(ERRORS, seed=1, window_s=6.0))


def test_twin_and_recording_are_compared_where_both_are_known() -> None:
    wandering = VEHICLE.model_copy(update={"estimator": ERRORS})
    compared = compare_wander(wandering, hover(ERRORS, seed=3))
    assert compared is not None
    assert compared.twin.deviation_m == pytest.approx(compared.recorded.deviation_m, rel=0.6)
    assert compare_wander(VEHICLE.model_copy(update={"estimator": None}), hover(ERRORS, seed=3)) is None
    assert compare_wander(wandering, hover(ERRORS, seed=3, window_s=6.0)) is None
