import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from companion.arrays import Array, Vec3s
from companion.errors import InputError
from companion.trajectory import Limits, Trajectory
from companion.trajectory.limits import peaks_of, stretches
from companion.trajectory.route import Waypoint
from companion.trajectory.waypoints import trajectory_through

LIMITS = Limits()
COORDINATE = st.one_of(st.floats(-60.0, 60.0), st.integers(-3, 3).map(float))  # integers: equal, collinear
POSITIONS = st.lists(st.tuples(COORDINATE, COORDINATE, COORDINATE), min_size=1, max_size=8)


def at(*position: float, within_m: float = 1.0, hold_s: float = 0.0, speed_m_s: float = 5.0) -> Waypoint:
    return Waypoint(np.array(position), within_m, hold_s, speed_m_s)


def positions_of(trajectory: Trajectory, every_s: float = 0.01) -> Vec3s:
    return trajectory.sample(np.arange(0.0, trajectory.duration_s + every_s, every_s)).position


def distance_to_line(points: Vec3s, start: Array, end: Array) -> Array:
    """From each point to the straight line between two others."""
    along = end - start
    share = np.clip((points - start) @ along / max(float(along @ along), 1e-12), 0.0, 1.0)
    return np.asarray(np.linalg.norm(points - start - share[:, None] * along, axis=1))


@settings(max_examples=50)
@given(
    positions=POSITIONS,
    within_m=st.floats(0.0, 5.0),
    hold_s=st.sampled_from([0.0, 0.0, 1.5]),
    speed_m_s=st.floats(0.3, 12.0),
    limits=st.sampled_from(
        [
            LIMITS,
            Limits(speed_m_s=2.0),
            LIMITS.within_vehicle(
                up_m_s=2.5, down_m_s=1.5, acceleration_m_s2=2.5, vertical_acceleration_m_s2=1.0
            ),
        ]
    ),
)
def test_any_waypoints(
    positions: list[tuple[float, float, float]],
    within_m: float,
    hold_s: float,
    speed_m_s: float,
    limits: Limits,
) -> None:
    """Limits hold, every waypoint is passed near enough, the path stays between the legs, the ends rest."""
    waypoints = [
        at(*position, within_m=within_m, hold_s=hold_s, speed_m_s=speed_m_s) for position in positions
    ]
    trajectory = trajectory_through("any", waypoints, limits)
    assert np.isfinite(trajectory.coefficients).all()
    peaks = peaks_of(trajectory)
    assert max(stretches(peaks, limits.peaks(usual_speed_m_s=math.inf)).values()) <= 1.0 + 1e-9
    assert peaks.speed_m_s <= 1.001 * speed_m_s
    flown = positions_of(trajectory)
    allowed_m = 0.0 if hold_s else within_m
    for waypoint in waypoints:
        assert np.linalg.norm(flown - waypoint.position, axis=1).min() <= allowed_m + 0.01 * speed_m_s + 0.002
    legs = [
        distance_to_line(flown, start.position, end.position)
        for start, end in zip(waypoints, waypoints[1:] or waypoints, strict=False)
    ]
    assert np.min(legs, axis=0).max() <= allowed_m + 0.005
    assert flown[0] == pytest.approx(waypoints[0].position, abs=0.002)
    assert flown[-1] == pytest.approx(waypoints[-1].position, abs=0.002)
    assert trajectory.derivative(1)[0, 0] == pytest.approx(np.zeros(3), abs=1e-6)
    assert trajectory.derivative(1)[-1].sum(axis=0) == pytest.approx(np.zeros(3), abs=1e-6)


@settings(max_examples=50)
@given(positions=st.lists(st.tuples(COORDINATE, COORDINATE, COORDINATE), min_size=3, max_size=6))
def test_jerk_is_continuous(positions: list[tuple[float, float, float]]) -> None:
    trajectory = trajectory_through("any", [at(*position) for position in positions], LIMITS)
    jerk = trajectory.derivative(3)
    jumps = np.linalg.norm(jerk[:-1].sum(axis=1) - jerk[1:, 0], axis=1)
    assert jumps.max(initial=0.0) < 0.15 * LIMITS.jerk_m_s3  # what is left is the knots' doing


def test_a_survey_line_is_straight_away_from_its_corners() -> None:
    waypoints = [at(0, 0, -20), at(60, 0, -20), at(60, 8, -20), at(0, 8, -20)]
    flown = positions_of(trajectory_through("lines", waypoints, LIMITS))
    on_first = flown[(flown[:, 0] > 4.0) & (flown[:, 0] < 56.0) & (flown[:, 1] < 4.0)]
    assert len(on_first) > 500
    assert np.abs(on_first - [0.0, 0.0, -20.0])[:, 1:].max() < 1e-9
    assert flown[:, 0].max() <= 60.0 + 1e-6
    assert flown[:, 1].min() >= -1e-6


def test_a_hold_is_exactly_there_and_as_long_as_asked() -> None:
    trajectory = trajectory_through("hold", [at(0, 0, -5), at(10, 0, -5, hold_s=3.0), at(10, 9, -5)], LIMITS)
    flown = positions_of(trajectory)
    there = np.linalg.norm(flown - [10.0, 0.0, -5.0], axis=1) < 1e-6
    assert 0.01 * there.sum() == pytest.approx(3.0, abs=0.15)


def test_a_straight_line_takes_hardly_longer_than_the_limits_need() -> None:
    """With acceleration a and jerk j from rest to rest at speed v: l / v + v / a + a / j."""
    trajectory = trajectory_through("line", [at(0, 0, -5), at(100, 0, -5)], LIMITS)
    least_s = 100.0 / 5.0 + 5.0 / 4.0 + 4.0 / 20.0
    assert least_s < trajectory.duration_s < 1.01 * least_s


def test_waypoints_on_a_line_are_passed_at_full_speed() -> None:
    dense = [at(float(north), 0.0, -5.0) for north in range(0, 101, 10)]
    ends = [dense[0], dense[-1]]
    durations = [trajectory_through("line", waypoints, LIMITS).duration_s for waypoints in (dense, ends)]
    assert durations[0] == pytest.approx(durations[1], rel=1e-6)


def test_a_wider_acceptance_is_faster() -> None:
    def duration_s(within_m: float) -> float:
        corner = [at(0, 0, -5), at(40, 0, -5, within_m=within_m), at(40, 40, -5)]
        return trajectory_through("corner", corner, LIMITS).duration_s

    assert duration_s(2.0) < duration_s(0.5) < duration_s(0.0)


def test_speed_of_each_leg() -> None:
    trajectory = trajectory_through(
        "speeds", [at(0, 0, -5), at(50, 0, -5, speed_m_s=2.0), at(100, 0, -5, speed_m_s=4.0)], LIMITS
    )
    samples = trajectory.sample(np.arange(0.0, trajectory.duration_s, 0.01))
    speed = np.linalg.norm(samples.velocity, axis=1)
    first = samples.position[:, 0] < 50.0
    assert speed[first].max() == pytest.approx(2.0, rel=1e-3)
    assert speed[~first].max() == pytest.approx(4.0, rel=1e-3)


def test_one_waypoint_is_a_hold() -> None:
    trajectory = trajectory_through("one", [at(1, 2, -3, hold_s=7.0)], LIMITS)
    assert trajectory.duration_s == pytest.approx(7.0)
    assert trajectory.at(3.0).position == pytest.approx([1.0, 2.0, -3.0])


def test_a_thousand_waypoints_over_kilometres() -> None:
    lines = [at(30.0 * (index // 2 % 2 != index % 2), 4.0 * (index // 2), -20.0) for index in range(1000)]
    trajectory = trajectory_through("long", lines, replace(LIMITS, speed_m_s=8.0))
    assert trajectory.duration_s > 1200.0
    assert max(stretches(peaks_of(trajectory), LIMITS.peaks(usual_speed_m_s=math.inf)).values()) <= 1.0 + 1e-9


@pytest.mark.parametrize(
    ("waypoints", "what"),
    [
        ([], "no waypoint"),
        ([at(0, 0, -5), at(math.nan, 0, -5)], "waypoint 2: its position"),
        ([at(0, 0, -5), at(5, 0, -5, speed_m_s=0.0)], "waypoint 2: speed"),
        ([at(0, 0, -5, hold_s=-1.0)], "waypoint 1: hold_s"),
        ([at(0, 0, -5), at(40_000, 0, -5)], "split it"),
    ],
)
def test_what_makes_no_sense_is_refused(waypoints: list[Waypoint], what: str) -> None:
    with pytest.raises(InputError, match=what):
        trajectory_through("none", waypoints, LIMITS)
