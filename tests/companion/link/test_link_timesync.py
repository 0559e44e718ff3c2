import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from companion.link.timesync import ClockOffset

OFFSET_S = 1000.0
PERIOD_S = 0.01

seeds = st.integers(min_value=0, max_value=2**32 - 1)
latencies = st.floats(min_value=0.0, max_value=0.1)


def fly(
    offset: ClockOffset,
    *,
    start_s: float = 10.0,
    duration_s: float = 8.0,
    up_s: float = 0.02,
    down_s: float = 0.02,
    jitter_s: float = 0.0,
    drift: float = 0.0,
    round_trips: bool = True,
    seed: int = 0,
    clock_offset_s: float = OFFSET_S,
) -> list[tuple[float, float, float]]:
    """(true time, estimated time, arrival) of telemetry at 100 Hz, with round trips at 10 Hz."""
    random = np.random.default_rng(seed)

    def late() -> float:
        return float(random.uniform(max(0.0, down_s - jitter_s), down_s + jitter_s))

    events: list[tuple[float, float, float | None]] = []
    for k in range(round(duration_s / PERIOD_S)):
        vehicle_s = start_s + k * PERIOD_S
        true_s = clock_offset_s + vehicle_s * (1.0 + drift)
        events.append((true_s + late(), vehicle_s, None))
        if round_trips and k % 10 == 0:
            events.append((true_s + late(), vehicle_s, true_s - up_s))
    results = []
    newest_s = -np.inf
    for arrival_s, vehicle_s, asked_s in sorted(events, key=lambda event: event[0]):
        if asked_s is not None:
            offset.round_trip(asked_s, vehicle_s, arrival_s)
        elif vehicle_s > newest_s:
            newest_s = vehicle_s
            estimated_s = offset.companion_time(vehicle_s, arrival_s)
            results.append((clock_offset_s + vehicle_s * (1.0 + drift), estimated_s, arrival_s))
    return results


@settings(deadline=None, max_examples=40)
@given(seeds, latencies, latencies, latencies, st.floats(min_value=-1e-4, max_value=1e-4), st.booleans())
def test_times_rise_and_lie_before_the_arrival(
    seed: int, up_s: float, down_s: float, jitter_s: float, drift: float, round_trips: bool
) -> None:
    flown = fly(
        ClockOffset(),
        up_s=up_s,
        down_s=down_s,
        jitter_s=jitter_s,
        drift=drift,
        round_trips=round_trips,
        seed=seed,
    )
    _, estimated, arrival = np.array(flown).T
    assert (np.diff(estimated) > 0.0).all()
    assert (estimated <= arrival).all()


@settings(deadline=None, max_examples=20)
@given(seeds)
def test_jitter_of_the_link_hardly_shows(seed: int) -> None:
    true, estimated, _ = np.array(fly(ClockOffset(), jitter_s=0.01, seed=seed)).T
    error = (estimated - true)[len(true) // 2 :]
    assert np.abs(error).max() < 0.006
    assert error.std() < 0.002
    assert np.abs(np.diff(error)).max() < 0.001


@settings(deadline=None, max_examples=20)
@given(latencies, latencies)
def test_an_asymmetric_link_costs_half_its_asymmetry(up_s: float, down_s: float) -> None:
    true, estimated, _ = np.array(fly(ClockOffset(), up_s=up_s, down_s=down_s)).T
    assert (estimated - true)[-1] == pytest.approx(0.5 * (down_s - up_s), abs=1e-3)


def test_without_round_trips_the_least_late_frame_counts() -> None:
    true, estimated, _ = np.array(fly(ClockOffset(), jitter_s=0.01, round_trips=False)).T
    error = (estimated - true)[len(true) // 2 :]
    assert error.min() > 0.0
    assert error.max() < 0.013


def test_round_trips_of_a_foreign_clock_are_not_believed() -> None:
    offset = ClockOffset()
    for asked_s in np.arange(990.0, 1010.0, 0.1):
        offset.round_trip(asked_s, 1.7e9, asked_s + 0.04)
    true, estimated, _ = np.array(fly(offset, round_trips=False)).T
    assert np.abs(estimated - true).max() < 0.03


def test_a_drifting_clock_is_followed() -> None:
    true, estimated, _ = np.array(fly(ClockOffset(), drift=0.01, duration_s=20.0)).T
    assert np.abs((estimated - true)[-1]) < 0.03


def test_better_knowledge_is_taken_in_slowly() -> None:
    offset = ClockOffset()
    fly(offset, up_s=0.0, down_s=0.4, round_trips=False)
    _, estimated, _ = np.array(fly(offset, start_s=18.0, up_s=0.0, down_s=0.4)).T
    assert (np.diff(estimated) > 0.89 * PERIOD_S).all()
    assert estimated[-1] - estimated[0] < 7.85


def test_a_reboot_starts_anew() -> None:
    offset = ClockOffset()
    before = fly(offset, start_s=100.0)
    after = fly(offset, start_s=0.1, clock_offset_s=OFFSET_S + 100.0 + 20.0)
    _, estimated, _ = np.array(before + after).T
    assert (np.diff(estimated) > 0.0).all()
    true, estimated, _ = np.array(after).T
    assert np.abs(estimated - true)[0] < 0.025
    assert np.abs(estimated - true)[-1] < 0.001


def test_a_vehicle_clock_that_leapt_ahead_is_a_new_one() -> None:
    offset = ClockOffset()
    before = fly(offset, start_s=10.0)
    after = fly(offset, start_s=60.0, clock_offset_s=OFFSET_S - 40.0)
    true, estimated, arrival = np.array(after).T
    assert estimated[0] > before[-1][1]
    assert (estimated <= arrival).all()
    assert np.abs(estimated - true)[-1] < 0.001


def test_a_vehicle_that_stood_still_is_found_again() -> None:
    offset = ClockOffset()
    fly(offset, start_s=10.0)
    after = fly(offset, start_s=18.0, clock_offset_s=OFFSET_S + 30.0)
    true, estimated, _ = np.array(after).T
    assert np.abs(estimated - true)[-1] < 0.001
    assert (np.diff(estimated) > 0.0).all()
