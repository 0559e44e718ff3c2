"""How long until a vehicle tracks as before, on errors that are made up."""

import numpy as np
import pytest

from companion.arrays import Times
from companion.experiments.flights import Flight
from companion.experiments.recovery import recovery_s

TIME_S = np.arange(0.0, 10.0, 0.01)


def flight(error_m: Times) -> Flight:
    flown = np.column_stack((error_m, np.zeros_like(error_m), np.zeros_like(error_m)))
    return Flight("made up", "gp", TIME_S, np.zeros_like(flown), flown, 0.0)


def error(*excursions: tuple[float, float]) -> Times:
    """1 cm, and 5 cm from each time to each other."""
    error_m = np.full_like(TIME_S, 0.01)
    for begin_s, end_s in excursions:
        error_m[round(100 * begin_s) : round(100 * end_s)] = 0.05
    return error_m


@pytest.mark.parametrize(
    ("excursions", "expected_s"),
    [
        ([(4.0, 5.5)], 1.5),
        ([(4.3, 5.0)], 1.0),  # it shows late
        ([(4.0, 4.5), (5.0, 6.0)], 2.0),  # back for half a second only
        ([(4.0, 4.5), (6.0, 6.5)], 0.5),  # the second has nothing to do with it
        ([(5.5, 6.0)], 0.0),
        ([(1.0, 1.5)], 0.0),
    ],
)
def test_from_the_event_until_it_is_back_and_stays(
    excursions: list[tuple[float, float]], expected_s: float
) -> None:
    assert recovery_s(flight(error(*excursions)), 4.0) == pytest.approx(expected_s, abs=0.011)


def test_an_error_that_stays_never_recovers() -> None:
    assert recovery_s(flight(error((4.0, 20.0))), 4.0) is None


def test_twice_the_rms_before_is_still_as_before() -> None:
    assert recovery_s(flight(np.where(TIME_S < 4.0, 0.01, 0.0199)), 4.0) == 0.0
    assert recovery_s(flight(np.where(TIME_S < 4.0, 0.01, 0.0201)), 4.0) is None


def test_nothing_flown_before_tells_nothing() -> None:
    assert recovery_s(flight(error((4.0, 5.0))), 0.0) is None
