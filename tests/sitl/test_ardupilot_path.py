import math

import numpy as np
import pytest

from sitl.arrays import Array, Vec3
from sitl.firmware.ardupilot_guidance import Guidance
from sitl.firmware.ardupilot_parameters import ArduPilotParameters
from sitl.firmware.ardupilot_path import Follow, Path, path, path_limits, shape_path
from sitl.firmware.interface import Setpoint

DT = 0.0025
PARAMETERS = ArduPilotParameters()


def at(north: float, east: float, down: float) -> Vec3:
    return np.array((north, east, down))


def start() -> tuple[Guidance, Path]:
    now = path()
    return Guidance(PARAMETERS, now), now


def fly(guidance: Guidance, now: Path, seconds: float) -> Array:
    """Rows: position, velocity and acceleration of the path."""
    rows = []
    for _ in range(round(seconds / DT)):
        shape_path(path_limits(PARAMETERS), guidance.target, now, DT)
        rows.append(np.concatenate((now.position, now.velocity, now.acceleration)))
    return np.array(rows)


def test_limits_come_from_the_parameters() -> None:
    limits = path_limits(PARAMETERS)
    assert (limits.speed, limits.up, limits.down) == (10.0, 2.5, 1.5)
    assert (limits.acceleration, limits.vertical_acceleration) == (2.5, 1.0)
    assert (limits.jerk, limits.vertical_jerk) == (5.0, 5.0)
    slow = ArduPilotParameters(ATC_ACCEL_R_MAX=9000.0, PSC_ACCZ_FLTE=2.0)
    assert path_limits(slow).jerk == pytest.approx(0.5 * math.sqrt(2.5 * math.radians(90.0) * 9.80665))
    assert path_limits(slow).vertical_jerk == pytest.approx(2.0 * math.pi * 2.0 / 5.0)


def test_a_place_is_reached_straight_and_within_limits() -> None:
    guidance, now = start()
    assert guidance.follow(Setpoint(position=at(20.0, -10.0, -10.0)))
    flown = fly(guidance, now, 25.0)
    assert flown[-1] == pytest.approx((20.0, -10.0, -10.0, *[0.0] * 6), abs=0.02)
    assert np.linalg.norm(flown[:, 3:5], axis=1).max() < 10.0
    assert flown[:, 5].min() >= -2.6
    assert np.linalg.norm(flown[:, 6:8], axis=1).max() <= 2.5 + 1e-6
    assert np.abs(flown[:, 8]).max() <= 1.0 + 1e-6
    jerk = np.diff(flown[:, 6:9], axis=0) / DT
    assert np.linalg.norm(jerk[:, :2], axis=1).max() <= 5.0 + 1e-6
    middle = flown[len(flown) // 8, :3]
    assert np.linalg.norm(np.cross(middle, flown[-1, :3])) / np.linalg.norm(flown[-1, :3]) < 2.0


def test_a_trajectory_with_acceleration_is_followed_exactly_once_reached() -> None:
    guidance, now = start()
    for tick in range(2000):
        phase = 0.01 * tick
        circle = at(math.cos(phase), math.sin(phase), 0.0)
        speed = at(-math.sin(phase), math.cos(phase), 0.0)
        guidance.follow(Setpoint(position=circle, velocity=speed, acceleration=-circle))
        fly(guidance, now, 0.01)
    # The target has moved on by one more loop at 1 m/s.
    assert now.position == pytest.approx(guidance.target.position, abs=1.1 * DT)
    assert now.velocity == pytest.approx(guidance.target.velocity, abs=1.1 * DT)


def test_a_trajectory_goes_on_between_setpoints_until_they_are_lost() -> None:
    guidance, now = start()
    guidance.follow(Setpoint(position=at(0.0, 0.0, 0.0), velocity=at(1.0, 0.0, 0.0)))
    fly(guidance, now, 2.0)
    assert guidance.target.position == pytest.approx((2.0, 0.0, 0.0))
    guidance.lose_setpoints()
    fly(guidance, now, 10.0)
    assert now.position == pytest.approx((2.0, 0.0, 0.0), abs=0.01)


@pytest.mark.parametrize("acceleration", [at(math.nan, math.nan, math.nan), at(0.5, 0.0, 0.0)])
def test_a_velocity_is_held_and_lost(acceleration: Vec3) -> None:
    guidance, now = start()
    guidance.follow(Setpoint(velocity=at(2.0, 0.0, -1.0), acceleration=acceleration))
    fly(guidance, now, 4.0)
    push = 0.0 if math.isnan(acceleration[0]) else 2.0
    assert now.velocity == pytest.approx((2.0 + push, 0.0, -1.0), abs=0.01)
    guidance.lose_setpoints()
    fly(guidance, now, 8.0)
    assert now.velocity == pytest.approx((0.0, 0.0, 0.0), abs=1e-3)


def test_an_acceleration_alone_is_reached_by_the_jerk_and_lost() -> None:
    guidance, now = start()
    guidance.follow(Setpoint(acceleration=at(1.0, 0.0, -0.5)))
    fly(guidance, now, 1.0)
    assert now.acceleration == pytest.approx((1.0, 0.0, -0.5))
    guidance.lose_setpoints()
    assert guidance.target.follow[0] == Follow.VELOCITY
    fly(guidance, now, 8.0)
    assert now.velocity == pytest.approx((0.0, 0.0, 0.0), abs=1e-3)


@pytest.mark.parametrize(
    "setpoint",
    [
        Setpoint(),
        Setpoint(position=at(1.0, math.nan, 0.0)),
        Setpoint(position=at(1.0, 0.0, 0.0), acceleration=at(1.0, 0.0, 0.0)),
    ],
)
def test_what_guided_does_not_know_stops_it(setpoint: Setpoint) -> None:
    guidance, now = start()
    guidance.follow(Setpoint(velocity=at(2.0, 0.0, 0.0)))
    fly(guidance, now, 3.0)
    assert guidance.follow(setpoint)
    fly(guidance, now, 5.0)
    assert now.velocity == pytest.approx((0.0, 0.0, 0.0), abs=1e-3)


def test_a_setpoint_of_the_same_kind_does_not_begin_anew() -> None:
    guidance, _ = start()
    assert guidance.follow(Setpoint(velocity=at(2.0, 0.0, 0.0))) is False  # stopping is a velocity, too
    assert guidance.follow(Setpoint(position=at(2.0, 0.0, 0.0)))
    assert not guidance.follow(Setpoint(position=at(3.0, 0.0, 0.0)))


def test_the_path_waits_where_the_vehicle_cannot_follow() -> None:
    guidance, now = start()
    guidance.follow(Setpoint(velocity=at(2.0, 0.0, -1.0)))
    now.limit[:] = 1.0, 0.0, -1.0
    now.position_error[:] = now.velocity_error[:] = 1.0, 0.0, -1.0
    fly(guidance, now, 2.0)
    assert now.position == pytest.approx((0.0, 0.0, 0.0))
    assert now.velocity == pytest.approx((0.0, 0.0, 0.0))


def test_a_path_that_sinks_too_fast_brakes_harder() -> None:
    guidance, now = start()
    now.velocity[2] = 6.0
    guidance.stop()
    flown = fly(guidance, now, 8.0)
    assert flown[:, 8].min() < -2.0
    assert flown[-1, 5] == pytest.approx(0.0, abs=1e-3)


def test_a_descent_slows_down_near_the_ground() -> None:
    guidance, _ = start()
    guidance.descend(30.0)
    assert guidance.target.velocity == pytest.approx((0.0, 0.0, 1.5))  # WPNAV_SPEED_DN
    guidance.descend(10.0)
    assert guidance.target.velocity == pytest.approx((0.0, 0.0, 0.5))  # LAND_SPEED


def test_setpoint_shows_what_counts() -> None:
    guidance, _ = start()
    guidance.follow(Setpoint(position=at(1.0, 2.0, -3.0), yaw=0.3))
    shown = guidance.setpoint
    assert shown.position == pytest.approx((1.0, 2.0, -3.0))
    assert np.isnan(shown.velocity).all()
    assert np.isnan(shown.acceleration).all()
    assert (shown.yaw, shown.yaw_rate) == (0.3, 0.0)
    guidance.take_off(-5.0)
    assert np.isnan(guidance.setpoint.position[:2]).all()
    assert guidance.setpoint.position[2] == -5.0
