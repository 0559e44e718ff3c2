"""The newest seconds of a flight."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from companion.flight.recent import SPAN_S, Recent
from companion.flight.reference import Reference
from companion.state import VehicleState


def state(time_s: float) -> VehicleState:
    return VehicleState(time_s, time_s, np.full(3, time_s), *np.zeros((3, 3)))


def sent(time_s: float) -> Reference:
    return Reference(np.full(3, time_s), np.zeros(3))


def test_nothing_flown_is_nothing() -> None:
    recent = Recent()
    recent.state(state(1.0))
    states, references = recent.series()
    assert len(states.time_s) == len(references.time_s) == 0
    assert states.position.shape == references.acceleration.shape == (0, 3)


@given(st.lists(st.floats(0.0, 0.4), min_size=1, max_size=200))
def test_the_newest_seconds_are_kept(gaps_s: list[float]) -> None:
    recent = Recent()
    times_s = np.cumsum(gaps_s)
    for time_s in times_s:
        recent.sent(float(time_s), sent(time_s), 0.5)
        recent.state(state(float(time_s)))
    kept = times_s[times_s >= times_s[-1] - SPAN_S]
    states, references = recent.series()
    np.testing.assert_array_equal(states.time_s, kept)
    np.testing.assert_array_equal(references.time_s, kept)
    np.testing.assert_array_equal(states.position[:, 2], kept)
    assert np.isnan(references.acceleration).all()


def test_a_landing_does_not_push_out_what_was_flown() -> None:
    recent = Recent()
    recent.sent(10.0, sent(10.0), 0.0)
    for time_s in (10.2, 10.1, 11.0, 60.0):
        recent.state(state(time_s))
    states, references = recent.series()
    np.testing.assert_array_equal(states.time_s, (10.1, 10.2))
    np.testing.assert_array_equal(references.time_s, (10.0,))


def test_a_flood_is_bounded() -> None:
    recent = Recent()
    for k in range(5000):
        recent.sent(1e-4 * k, sent(k), 0.0)
        recent.state(state(1e-4 * k))
    states, references = recent.series()
    assert len(states.time_s) == len(references.time_s) == 4000
    assert references.position[-1, 0] == 4999.0
