"""What a vehicle's parameters say of its fence."""

import pytest

from companion.flight.vehicle_fence import Bound, Bounds
from companion.mission.fence_parameters import bounds_of, counts_all

PX4 = {"GF_ACTION": 2, "GF_MAX_HOR_DIST": 30.0, "GF_MAX_VER_DIST": 10.0}
COPTER = {
    "FENCE_ENABLE": 1,
    "FENCE_TYPE": 15,
    "FENCE_ALT_MAX": 100.0,
    "FENCE_ALT_MIN": -10.0,
    "FENCE_RADIUS": 300.0,
    "FENCE_MARGIN": 2.0,
}


def limits_m(bounds: Bounds) -> tuple[float | None, ...]:
    """What each parameter itself says."""
    return tuple(
        None if bound is None else bound.value_m for bound in (bounds.distance, bounds.ceiling, bounds.floor)
    )


@pytest.mark.parametrize(
    ("values", "limits"),
    [
        ({}, (30.0, 10.0, None)),
        ({"GF_ACTION": 1}, (30.0, 10.0, None)),
        ({"GF_ACTION": 0}, (None, None, None)),
        ({"GF_MAX_HOR_DIST": 0.0}, (None, 10.0, None)),
        ({"GF_MAX_VER_DIST": 0.0}, (30.0, None, None)),
    ],
)
def test_px4_has_a_distance_and_a_ceiling(values: dict[str, float], limits: tuple[float | None, ...]) -> None:
    assert limits_m(bounds_of(PX4 | values)) == limits


@pytest.mark.parametrize(
    ("values", "limits"),
    [
        ({}, (300.0, 100.0, -10.0)),
        ({"FENCE_TYPE": 7}, (300.0, 100.0, None)),
        ({"FENCE_TYPE": 4}, (None, None, None)),
        ({"FENCE_TYPE": 9}, (None, 100.0, -10.0)),
        ({"FENCE_ENABLE": 0}, (None, None, None)),
        ({"FENCE_ENABLE": 0, "FENCE_AUTOENABLE": 3}, (300.0, 100.0, -10.0)),
    ],
)
def test_ardupilot_has_what_its_bits_say(values: dict[str, float], limits: tuple[float | None, ...]) -> None:
    assert limits_m(bounds_of(COPTER | values)) == limits


def test_setpoints_keep_the_margin_that_ardupilot_asks_for() -> None:
    bounds = bounds_of(COPTER)
    assert (bounds.distance_m, bounds.altitude_m) == (298.0, (-8.0, 98.0))


def test_what_is_not_told_bounds_nothing() -> None:
    assert bounds_of({}) == Bounds()
    assert bounds_of({"GF_MAX_VER_DIST": 10.0}) == Bounds(
        ceiling=Bound(parameter="GF_MAX_VER_DIST", value_m=10.0, margin_m=0.5)
    )
    assert limits_m(bounds_of({"FENCE_TYPE": 3, "FENCE_RADIUS": 50.0})) == (50.0, None, None)


@pytest.mark.parametrize(
    ("options", "in_all"), [({}, True), ({"FENCE_OPTIONS": 1}, True), ({"FENCE_OPTIONS": 3}, False)]
)
def test_all_areas_count_unless_one_is_said_to_be_enough(options: dict[str, int], in_all: bool) -> None:
    assert counts_all(options) is in_all
