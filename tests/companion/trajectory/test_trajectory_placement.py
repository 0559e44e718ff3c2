import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from companion.errors import InputError
from companion.trajectory.placement import Placement

RIGHT_THEN_UP = np.array([[0.0, 0.0], [20.0, 0.0], [20.0, 10.0]])


def test_upright_x_is_north_and_y_is_up() -> None:
    corner = Placement(size_m=2.0).place(RIGHT_THEN_UP)
    np.testing.assert_allclose(corner, [[-1.0, 0.0, -1.5], [1.0, 0.0, -1.5], [1.0, 0.0, -2.5]])


def test_level_x_is_north_and_y_is_east() -> None:
    corner = Placement(size_m=2.0, plane="xy").place(RIGHT_THEN_UP)
    np.testing.assert_allclose(corner, [[-1.0, -0.5, -1.5], [1.0, -0.5, -1.5], [1.0, 0.5, -1.5]])


def test_heading_east_turns_x_to_the_east() -> None:
    east = np.pi / 2
    upright = Placement(size_m=2.0, heading_rad=east).place(RIGHT_THEN_UP)
    np.testing.assert_allclose(upright[1] - upright[0], [0.0, 2.0, 0.0], atol=1e-12)
    level = Placement(size_m=2.0, heading_rad=east, plane="xy").place(RIGHT_THEN_UP)
    np.testing.assert_allclose(level[2] - level[1], [-1.0, 0.0, 0.0], atol=1e-12)


def test_flipped_y_grows_downwards() -> None:
    corner = Placement(size_m=2.0, flip_y=True).place(RIGHT_THEN_UP)
    np.testing.assert_allclose(corner[:, 2], [-2.5, -2.5, -1.5])


@given(
    size_m=st.floats(0.1, 50.0),
    altitude_m=st.floats(1.5, 30.0),
    north=st.floats(-20.0, 20.0),
    unit=st.sampled_from([1e-6, 1.0, 1e6]),
)
def test_size_height_and_middle_whatever_the_unit(
    size_m: float, altitude_m: float, north: float, unit: float
) -> None:
    points = unit * np.random.default_rng(0).normal(size=(30, 2))
    placed = Placement(size_m=size_m, altitude_m=altitude_m, origin=(north, 2.0)).place(points)
    lowest, highest = placed.min(axis=0), placed.max(axis=0)
    assert (highest - lowest).max() == pytest.approx(size_m)
    assert -highest[2] == pytest.approx(altitude_m)
    np.testing.assert_allclose(0.5 * (lowest + highest)[:2], [north, 2.0], atol=1e-9)


@pytest.mark.parametrize(
    ("placement", "message"),
    [
        ({"size_m": 0.0}, "size"),
        ({"size_m": float("nan")}, "size"),
        ({"altitude_m": 1.0}, "altitude"),
        ({"plane": "yz"}, "plane"),
        ({"origin": (float("inf"), 0.0)}, "origin"),
        ({"heading_rad": float("nan")}, "heading"),
    ],
)
def test_a_wrong_placement_is_refused(placement: dict[str, object], message: str) -> None:
    with pytest.raises(InputError, match=message):
        Placement(**placement)  # type: ignore[arg-type]
