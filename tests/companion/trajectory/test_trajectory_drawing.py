import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from jaxtyping import Float
from scipy.spatial import cKDTree

from companion.arrays import Array, Vec3s
from companion.errors import InputError
from companion.trajectory.drawing import SPEED_M_S, TOLERANCE, Drawing, drawing_trajectory
from companion.trajectory.limits import Limits, Peaks
from companion.trajectory.placement import Placement
from companion.trajectory.smoothing import evenly_spaced, lengths
from companion.trajectory.summary import summarise
from companion.trajectory.trajectory import Trajectory

SQUARE = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0], [0.0, 0.0]])
LINE = np.array([[0.0, 0.0], [1.0, 1.0]])
THERE_AND_BACK = np.array([[0.0, 0.0], [1.0, 1.0], [0.0, 0.0]])


def eight(count: int, tremor: float = 0.0) -> Float[Array, "n 2"]:
    """A figure of eight of size 1."""
    angle = np.linspace(0.0, 2.0 * np.pi, count)
    noise = tremor * np.random.default_rng(0).normal(size=(count, 2))
    return 0.5 * np.stack([np.cos(angle), np.sin(2.0 * angle)], axis=1) + noise


def fly(
    points: Float[Array, "n 2"],
    times: Float[Array, " n"] | None = None,
    placement: Placement | None = None,
    limits: Limits | None = None,
) -> Trajectory:
    return drawing_trajectory(Drawing("it", points, times), placement or Placement(), limits or Limits())


def dense_peaks(trajectory: Trajectory) -> Peaks:
    """Peaks from samples alone, at 5000 instants that have nothing to do with the knots."""
    times = np.linspace(0.0, trajectory.duration_s, 5001)
    _, velocity, acceleration = trajectory.sample(times)
    jerk = np.diff(acceleration, axis=0) / (times[1] - times[0])
    return Peaks(
        speed_m_s=norms(velocity).max(),
        acceleration_m_s2=norms(acceleration).max(),
        jerk_m_s3=norms(jerk).max(),
        up_m_s=-velocity[:, 2].min(),
        down_m_s=velocity[:, 2].max(),
        vertical_acceleration_m_s2=np.abs(acceleration[:, 2]).max(),
    )


def norms(vectors: Vec3s) -> Float[Array, " n"]:
    return np.asarray(np.linalg.norm(vectors, axis=1))


def assert_flyable(trajectory: Trajectory, limits: Limits) -> None:
    allowed = limits.peaks(usual_speed_m_s=SPEED_M_S)
    for name, peak in vars(dense_peaks(trajectory)).items():
        assert peak <= getattr(allowed, name) * 1.005, name
    first, last = (trajectory.at(time_s) for time_s in (1e-9, trajectory.duration_s - 1e-9))
    for end in (first, last):
        assert max(np.abs(end.velocity).max(), np.abs(end.acceleration).max()) < 1e-5


@settings(deadline=None, max_examples=60)
@given(
    points=st.lists(st.tuples(*2 * [st.integers(0, 100)]), min_size=2, max_size=30, unique=True),
    timed=st.booleans(),
    seed=st.integers(0, 99),
    plane=st.sampled_from(["xz", "xy"]),
    limits=st.builds(
        Limits, speed_m_s=st.none() | st.floats(0.3, 5.0), acceleration_m_s2=st.floats(1.0, 8.0)
    ),
)
def test_any_drawing_is_flown_within_the_limits_of_which_one_binds(
    points: list[tuple[int, int]], timed: bool, seed: int, plane: str, limits: Limits
) -> None:
    steps = np.random.default_rng(seed).uniform(0.1, 1.0, len(points))
    placement = Placement(plane="xz" if plane == "xz" else "xy")
    trajectory = fly(np.array(points, dtype=float), np.cumsum(steps) if timed else None, placement, limits)
    assert_flyable(trajectory, limits)
    assert summarise(trajectory, limits).bound_by
    path = trajectory.sample(np.linspace(0.0, trajectory.duration_s, 4001)).position
    assert np.ptp(path, axis=0).max() == pytest.approx(placement.size_m, abs=2e-3)
    assert -path[:, 2].max() == pytest.approx(placement.altitude_m, abs=1e-3)


@pytest.mark.parametrize("points", [SQUARE, LINE, THERE_AND_BACK, eight(20), eight(10_000)])
def test_without_times_the_asked_speed_is_reached(points: Float[Array, "n 2"]) -> None:
    trajectory = fly(points)
    assert_flyable(trajectory, Limits())
    assert dense_peaks(trajectory).speed_m_s == pytest.approx(1.2, rel=0.02)


@pytest.mark.parametrize("points", [SQUARE, eight(200), eight(200)[::-1]])
def test_the_path_keeps_close_to_the_drawing(points: Float[Array, "n 2"]) -> None:
    placement = Placement()
    trajectory = fly(points, placement=placement)
    flown = trajectory.sample(np.linspace(0.0, trajectory.duration_s, 5000)).position
    drawn = placement.place(evenly_spaced(points, lengths(points)))
    for one, other in ((flown, drawn), (drawn, flown)):
        distances = np.asarray(cKDTree(other).query(one)[0])
        assert distances.max() < 2.0 * TOLERANCE * placement.size_m
    for end in (0, -1):
        assert np.linalg.norm(flown[end] - drawn[end]) < 2.0 * TOLERANCE * placement.size_m


def test_natural_timing_is_kept_in_proportion() -> None:
    points = np.stack([np.linspace(0.0, 1.0, 300), np.zeros(300)], axis=1)
    times = np.where(points[:, 0] < 0.5, points[:, 0], 1.5 * points[:, 0] - 0.25)
    trajectory = fly(points, times, limits=Limits(speed_m_s=0.6))
    _, velocity, _ = trajectory.sample(trajectory.duration_s * np.array([0.25, 0.75]))
    assert velocity[0, 0] / velocity[1, 0] == pytest.approx(1.5, rel=0.02)


@pytest.mark.parametrize("unit", [1e-6, 1.0, 1e9])
@pytest.mark.parametrize("tick", [1e-6, 1.0, 1e9])
def test_units_of_a_drawing_do_not_matter(unit: float, tick: float) -> None:
    angle = np.linspace(0.0, 1.0, 200)
    expected = fly(eight(200), angle)
    trajectory = fly(unit * eight(200), 5.0 * tick + tick * angle)
    assert trajectory.duration_s == pytest.approx(expected.duration_s, rel=1e-6)
    times = np.linspace(0.0, expected.duration_s, 50)
    np.testing.assert_allclose(trajectory.sample(times).position, expected.sample(times).position, atol=1e-5)


@pytest.mark.parametrize("count", [500, 5000])
@pytest.mark.parametrize("timed", [True, False])
def test_tremor_does_not_slow_the_flight(count: int, timed: bool) -> None:
    times = np.linspace(0.0, 1.0, count) if timed else None
    steady = fly(eight(count), times).duration_s
    assert fly(eight(count, tremor=0.005), times).duration_s < 1.1 * steady


@pytest.mark.parametrize("size_m", [0.05, 1.0, 30.0])
def test_a_closed_loop_of_any_size(size_m: float) -> None:
    trajectory = fly(SQUARE, placement=Placement(size_m=size_m))
    assert_flyable(trajectory, Limits())
    first, last = trajectory.at(0.0).position, trajectory.at(trajectory.duration_s).position
    assert np.linalg.norm(first - last) < 2.0 * TOLERANCE * size_m


def test_a_rest_of_the_pen_is_kept() -> None:
    points = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 0.0], [2.0, 0.0]])
    trajectory = fly(points, np.array([0.0, 1.0, 3.0, 4.0]))
    middle = trajectory.at(0.5 * trajectory.duration_s)
    assert norms(middle.velocity[None])[0] < 0.02


@pytest.mark.parametrize("points", [np.ones((5, 2)), 1e9 + np.array([[0.0, 0.0], [1e-3, 0.0]])])
def test_points_that_are_all_the_same_are_refused(points: Float[Array, "n 2"]) -> None:
    with pytest.raises(InputError, match="all points are the same"):
        fly(points)


def test_what_takes_for_ever_is_refused() -> None:
    with pytest.raises(InputError, match="more than 1800 s"):
        fly(LINE, limits=Limits(speed_m_s=0.001))
