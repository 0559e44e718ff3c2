"""The table of watchdogs, by itself: limits, how long they last, and what is not known."""

import dataclasses
import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from pydantic import ValidationError

from companion.flight.expectation import Expectation
from companion.flight.watchdogs import Action, Readings, Since, Watchdog, Watchdogs, watch

NAMES = [field.name for field in dataclasses.fields(Readings)]
USUAL = Watchdogs()


def test_every_reading_has_a_row_and_every_row_but_one_a_reading() -> None:
    assert set(Watchdogs.model_fields) == {*NAMES, "state_age_s"}  # which the setpoint stream looks at itself


@pytest.mark.parametrize("name", NAMES)
def test_each_row_acts_beyond_its_limit_for_as_long_as_it_says(name: str) -> None:
    row: Watchdog = getattr(USUAL, name)
    readings = Readings(**{name: 1.1 * row.limit})
    since, alarms = watch(USUAL, readings, 10.0, {})
    assert [alarm.name for alarm in alarms] == ([] if row.lasts_s else [name])
    since, alarms = watch(USUAL, readings, 10.0 + row.lasts_s, since)
    (alarm,) = alarms
    assert alarm.watchdog is row
    assert f"watchdog {name}, limit {row.limit:g}" in str(alarm)
    assert watch(USUAL, Readings(**{name: row.limit}), 20.0, since) == ({}, [])


def test_what_is_not_known_alarms_nobody() -> None:
    assert watch(USUAL, Readings(), 0.0, {}) == ({}, [])


@given(st.lists(st.booleans(), min_size=1, max_size=40))
def test_an_alarm_needs_to_last_without_a_break(beyond: list[bool]) -> None:
    since: Since = {}
    for step, is_beyond in enumerate(beyond):
        value = 0.95 if is_beyond else 0.5
        since, alarms = watch(USUAL, Readings(battery_used=value), 0.5 * step, since)
        lasted = beyond[max(0, step - 4) : step + 1]
        assert bool(alarms) == (len(lasted) == 5 and all(lasted))


def test_what_a_row_leaves_out_is_its_own_default() -> None:
    table = Watchdogs.model_validate({"battery_used": {"limit": 0.7}, "lateness_s": {"action": "yield"}})
    assert table.battery_used == Watchdog(limit=0.7, lasts_s=2.0, action=Action.LAND)
    assert table.lateness_s == Watchdog(limit=0.9, action=Action.YIELD)
    assert table.computing == USUAL.computing


@pytest.mark.parametrize("row", [{"no_such": {"limit": 1.0}}, {"computing": {"action": "crash"}}, 3])
def test_a_wrong_table_is_refused(row: object) -> None:
    with pytest.raises(ValidationError):
        Watchdogs.model_validate(row)


@pytest.mark.parametrize("row", [{"lasts_s": 0.1}, {"action": "fall back"}])
def test_without_a_state_there_is_nothing_to_wait_for_or_to_fall_back_on(row: dict[str, object]) -> None:
    with pytest.raises(ValidationError, match="one that ends the flight: hold, land, return or yield"):
        Watchdogs.model_validate({"state_age_s": row})


def test_which_action_ends_a_flight_without_a_state_can_be_chosen() -> None:
    table = Watchdogs.model_validate({"state_age_s": {"limit": 0.3, "lasts_s": 0.0, "action": "land"}})
    assert table.state_age_s == Watchdog(limit=0.3, action=Action.LAND)


def test_expectations_that_do_not_come_true_show() -> None:
    expectation = Expectation()
    expectation.compare(0.0, np.array([1.0, 0.0, 0.0]))
    assert math.isnan(expectation.missed_m)
    expectation.expect(1.0, np.array([0.5, 0.0, 0.0]))
    expectation.compare(0.9, np.array([9.0, 0.0, 0.0]))
    assert math.isnan(expectation.missed_m)
    expectation.compare(1.0, np.array([0.5, 0.3, 0.0]))
    assert expectation.missed_m == pytest.approx(0.3)
    expectation.expect(2.0, np.array([math.nan, 0.0, 0.0]))
    expectation.compare(2.0, np.array([0.5, 0.3, 0.0]))
    assert expectation.missed_m == math.inf
    expectation.forget()
    assert math.isnan(expectation.missed_m)
