"""From wherever a flight is, a hold or a landing can be reached; and at once where the vehicle is ours."""

from itertools import product

import pytest
from hypothesis import given
from hypothesis import strategies as st

from companion.flight.states import TRANSITIONS, Event, FlightState, next_state

SAFE = {FlightState.HOLDING, FlightState.LANDING}
OURS_IN_THE_AIR = {
    FlightState.TAKING_OFF,
    FlightState.APPROACHING,
    FlightState.TRACKING,
    FlightState.HOLDING,
    FlightState.LANDING,
    FlightState.FAILED,
}
NOT_BY_US = {Event.TAKE, Event.FAIL, Event.LOSE}


def reachable(state: FlightState) -> set[FlightState]:
    """What our own events lead to."""
    found = {state}
    while True:
        more = {
            next_state(each, event) for each, event in product(found, Event) if event not in NOT_BY_US
        } - found
        if not more:
            return found
        found |= more


@pytest.mark.parametrize("state", FlightState)
def test_a_hold_or_a_landing_is_reached_from_everywhere(state: FlightState) -> None:
    assert reachable(state) >= SAFE


@pytest.mark.parametrize("state", sorted(OURS_IN_THE_AIR))
def test_a_vehicle_of_ours_holds_or_lands_at_once(state: FlightState) -> None:
    assert next_state(state, Event.HOLD) is FlightState.HOLDING
    assert next_state(state, Event.LAND) is FlightState.LANDING


@given(st.lists(st.sampled_from(Event)))
def test_whatever_happened_before(events: list[Event]) -> None:
    state = FlightState.DISCONNECTED
    for event in events:
        state = next_state(state, event)
    if state in OURS_IN_THE_AIR:
        assert next_state(state, Event.HOLD) is FlightState.HOLDING
    else:
        assert reachable(state) >= SAFE


@given(st.lists(st.sampled_from(Event)))
def test_who_lost_the_vehicle_to_its_pilot_gets_it_back_only_by_asking(events: list[Event]) -> None:
    state = FlightState.YIELDED
    for event in events:
        if event in (Event.RECLAIM, Event.GROUND, Event.LOSE):
            break
        state = next_state(state, event)
        assert state is FlightState.YIELDED


def test_every_state_and_event_is_of_use() -> None:
    assert {state for state, _ in TRANSITIONS} | set(TRANSITIONS.values()) == set(FlightState)
    assert {event for _, event in TRANSITIONS} == set(Event)


def test_what_has_no_meaning_changes_nothing() -> None:
    assert next_state(FlightState.TRACKING, Event.CONNECT) is FlightState.TRACKING
