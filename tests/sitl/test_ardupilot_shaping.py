import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from sitl.firmware.ardupilot_shaping import (
    closing_velocity_xy,
    inverse_sqrt_controller,
    limit_across_first,
    limit_correction,
    limit_length,
    shape_acceleration,
    shape_acceleration_xy,
    shape_velocity,
    shape_velocity_xy,
    speed_along,
    sqrt_controller,
)

errors = st.floats(-50.0, 50.0)
gains = st.floats(0.1, 10.0)
DT = 0.0025


# The square-root controller


def test_sqrt_controller_is_linear_near_zero_and_a_square_root_beyond() -> None:
    # Linear up to limit / p² = 0.5; there both branches and their slopes meet.
    assert sqrt_controller(0.4, 2.0, 2.0, 0.0) == pytest.approx(0.8)
    assert sqrt_controller(0.5, 2.0, 2.0, 0.0) == pytest.approx(1.0)
    assert sqrt_controller(2.5, 2.0, 2.0, 0.0) == pytest.approx(3.0)  # √(2 · 2 · (2.5 − 0.25))
    assert sqrt_controller(-2.5, 2.0, 2.0, 0.0) == pytest.approx(-3.0)


def test_sqrt_controller_without_limit_or_gain() -> None:
    assert sqrt_controller(3.0, 2.0, 0.0, 0.0) == pytest.approx(6.0)
    assert sqrt_controller(2.0, 0.0, 1.0, 0.0) == pytest.approx(2.0)
    assert sqrt_controller(0.0, 0.0, 1.0, 0.0) == 0.0


@given(errors, gains, gains, st.floats(0.001, 1.0))
def test_sqrt_controller_never_overshoots_in_a_step(error: float, p: float, limit: float, dt: float) -> None:
    step = sqrt_controller(error, p, limit, dt) * dt
    assert abs(step) <= abs(error) * (1.0 + 1e-9)
    assert step * error >= 0.0


@given(errors, gains, gains)
def test_inverse_gives_the_error_back(error: float, p: float, limit: float) -> None:
    rate = sqrt_controller(error, p, limit, 0.0)
    assert inverse_sqrt_controller(rate, p, limit) == pytest.approx(error, abs=1e-9)


def test_inverse_without_limit_or_gain() -> None:
    assert inverse_sqrt_controller(3.0, 2.0, 0.0) == pytest.approx(1.5)
    assert inverse_sqrt_controller(2.0, 0.0, 1.0) == pytest.approx(2.0)
    assert inverse_sqrt_controller(2.0, 0.0, 0.0) == 0.0


@given(errors, gains, st.floats(0.1, 5.0))
def test_following_it_never_brakes_harder_than_the_limit(error: float, p: float, limit: float) -> None:
    ahead = error * (1.0 - 1e-4)
    rate, later = sqrt_controller(error, p, limit, 0.0), sqrt_controller(ahead, p, limit, 0.0)
    if abs(error) > 1e-3 and abs(rate) > 1e-6:
        braking = (rate - later) / ((error - ahead) / rate)
        assert abs(braking) <= limit * (1.0 + 1e-3)


# Limits of vectors


@given(errors, errors, st.floats(0.1, 20.0))
def test_limited_vectors_keep_their_direction(x: float, y: float, longest: float) -> None:
    a, b = limit_length(x, y, longest)
    assert math.hypot(a, b) <= longest * (1.0 + 1e-9)
    assert a * y == pytest.approx(b * x, abs=1e-9)


@given(errors, errors, errors, errors, st.floats(0.1, 5.0))
def test_limited_accelerations_are_no_longer_than_allowed(
    x: float, y: float, u: float, v: float, most: float
) -> None:
    for limited in (limit_correction((u, v), x, y, most), limit_across_first((u, v), x, y, most)):
        assert math.hypot(*limited) <= most * (1.0 + 1e-9)


def test_a_correction_keeps_room_across_the_motion() -> None:
    # Braking hard while 5 m/s² are wanted across: √½ of 2 are kept, the rest brakes.
    along, across = limit_correction((3.0, 0.0), -10.0, 5.0, 2.0)
    assert across == pytest.approx(math.sqrt(2.0))
    assert along == pytest.approx(-math.sqrt(2.0))
    # Mostly across: cut in length alone.
    assert limit_correction((3.0, 0.0), 3.0, 4.0, 2.5) == pytest.approx((1.5, 2.0))
    assert limit_correction((0.0, 0.0), 3.0, 4.0, 2.5) == pytest.approx((1.5, 2.0))


def test_a_lean_turns_before_it_brakes() -> None:
    assert limit_across_first((3.0, 0.0), -4.0, 3.0, 4.0) == pytest.approx((-math.sqrt(7.0), 3.0))
    assert limit_across_first((3.0, 0.0), -4.0, 9.0, 4.0) == pytest.approx((0.0, 4.0))


def test_speed_along_a_slope() -> None:
    assert speed_along(1.0, 0.0, 0.0, 10.0, 2.5, 1.5) == pytest.approx(10.0)
    assert speed_along(0.0, 0.0, -1.0, 10.0, 2.5, 1.5) == pytest.approx(2.5)
    assert speed_along(0.0, 0.0, 1.0, 10.0, 2.5, 1.5) == pytest.approx(1.5)
    # Half down: the descent is the limit; hardly down: the horizontal speed is.
    assert speed_along(math.sqrt(0.5), 0.0, math.sqrt(0.5), 10.0, 2.5, 1.5) == pytest.approx(
        1.5 * math.sqrt(2.0)
    )
    assert speed_along(0.995, 0.0, 0.0998, 10.0, 2.5, 1.5) == pytest.approx(10.0 / 0.995)


# Shaping


@given(errors, errors, st.floats(0.5, 20.0))
def test_acceleration_changes_within_the_jerk(wanted: float, now: float, jerk: float) -> None:
    assert abs(shape_acceleration(wanted, now, jerk, DT) - now) <= jerk * DT * (1.0 + 1e-9)
    then = shape_acceleration_xy((wanted, -wanted), (now, now), jerk, DT)
    assert math.hypot(then[0] - now, then[1] - now) <= jerk * DT * (1.0 + 1e-9)


@given(st.floats(-5.0, 5.0), st.floats(-3.0, 3.0))
def test_velocity_is_reached_within_acceleration_and_without_overshoot(wanted: float, start: float) -> None:
    velocity, acceleration, largest = start, 0.0, 0.0
    furthest = start
    for _ in range(4000):
        acceleration = shape_velocity(wanted, 0.0, velocity, acceleration, 2.5, 5.0, DT)
        velocity += acceleration * DT
        largest = max(largest, abs(acceleration))
        furthest = max(furthest, velocity) if wanted > start else min(furthest, velocity)
    assert velocity == pytest.approx(wanted, abs=1e-3)
    assert largest <= 2.5 + 1e-9
    assert abs(furthest - wanted) <= 0.01 + 0.05 * abs(wanted - start)


def test_feed_forward_is_not_limited() -> None:
    assert shape_velocity(0.0, 7.0, 0.0, 7.0, 2.5, 5.0, DT) == pytest.approx(7.0)
    wanted, forward = (0.0, 0.0), (7.0, 1.0)
    assert shape_velocity_xy(wanted, forward, (0.0, 0.0), forward, 2.5, 5.0, DT) == pytest.approx(forward)


def test_closing_stops_at_the_target_and_keeps_its_speed_limit() -> None:
    assert closing_velocity_xy(0.0, 0.0, 5.0, 2.5, 5.0, DT) == (0.0, 0.0)
    assert closing_velocity_xy(300.0, 400.0, 5.0, 2.5, 5.0, DT) == pytest.approx((3.0, 4.0))
