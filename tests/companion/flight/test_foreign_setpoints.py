import math
from collections.abc import Callable

import numpy as np
import pytest

from companion.arrays import Vec3
from companion.flight.foreign_setpoints import ForeignSetpoints

SPEED_M_S = 2.0


def ours(time_s: float) -> Vec3:
    """What is sent at that time: along a line."""
    return np.array((SPEED_M_S * time_s, 0.0, -2.0))


def share_after(seconds: float, told: Callable[[float], Vec3 | None]) -> float:
    """Sent at 50 Hz, told at 10 Hz, looked at 20 times a second."""
    setpoints, share, newest = ForeignSetpoints(), math.nan, None
    for step in range(round(seconds * 100)):
        time_s = step / 100
        if step % 2 == 0:
            setpoints.sent(time_s, ours(time_s))
        if step % 10 == 0:
            newest = told(time_s)
        if step % 5 == 0:
            share = setpoints.share(newest)
    return share


@pytest.mark.parametrize("late_s", [0.0, 0.3, 0.9])
def test_our_own_come_back_late_and_are_ours(late_s: float) -> None:
    assert share_after(5.0, lambda time_s: ours(max(0.0, time_s - late_s))) == 0.0


def test_a_position_that_was_moved_on_a_little_is_ours() -> None:
    assert share_after(5.0, lambda time_s: ours(time_s + 0.2)) == 0.0


def test_those_of_another_program_are_not() -> None:
    def told(time_s: float) -> Vec3:
        beside = np.array((0.0, 3.0, 0.0))
        return ours(time_s) + (beside if round(time_s * 10) % 4 == 0 else 0.0)

    assert share_after(5.0, told) == pytest.approx(0.25)


def test_one_that_stays_where_it_was_is_not_ours_any_more() -> None:
    assert share_after(3.0, lambda time_s: ours(min(time_s, 1.0))) == pytest.approx(0.4, abs=0.11)
    assert share_after(5.0, lambda time_s: ours(min(time_s, 1.0))) == 1.0


@pytest.mark.parametrize("seconds", [0.5, 1.8])
def test_nothing_is_said_of_a_few(seconds: float) -> None:
    assert math.isnan(share_after(seconds, ours))


def test_nothing_is_said_where_nothing_is_told() -> None:
    assert math.isnan(share_after(5.0, lambda time_s: None))
