from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from companion.errors import InputError
from companion.trajectory.limits import Limits
from companion.trajectory.placement import Placement
from companion.trajectory.readers import read_trajectory
from companion.trajectory.trajectory import Trajectory

DRAWINGS = Path(__file__).parents[3] / "config" / "trajectories"


def read(path: Path, content: str | bytes) -> Trajectory:
    path.write_bytes(content if isinstance(content, bytes) else content.encode())
    return read_trajectory(path, Placement(), Limits())


@pytest.fixture
def file(tmp_path: Path) -> Path:
    return tmp_path / "it.csv"


def test_ned_is_taken_as_it_is(file: Path) -> None:
    trajectory = read(file, "t,n,e,d\n0,1,2,-3\n10,4,5,-6\n")
    np.testing.assert_allclose(trajectory.at(0.0).position, [1.0, 2.0, -3.0], atol=0.01)
    np.testing.assert_allclose(trajectory.at(99.0).position, [4.0, 5.0, -6.0], atol=0.01)
    assert trajectory.name == "it"


def test_xyz_is_north_east_up(file: Path) -> None:
    trajectory = read(file, "t,x,y,z\n0,1,2,3\n10,4,5,6\n")
    np.testing.assert_allclose(trajectory.at(0.0).position, [1.0, 2.0, -3.0], atol=0.01)
    np.testing.assert_allclose(trajectory.at(99.0).position, [4.0, 5.0, -6.0], atol=0.01)


@pytest.mark.parametrize(
    "content",
    [
        "t,x,y\n0,0,0\n1,2,1\n2,4,0\n",
        "T, X, Y\r\n0, 0, 0\r\n1, 2, 1\r\n2, 4, 0\r\n",
        "t,x,y\r0,0,0\r1,2,1\r2,4,0",
        "\ufefft,x,y\n0,0,0\n1,2,1\n2,4,0\n",
        "# drawn by hand\n\nt,x,y # ms\n0,0,0\n\n1,2,1\n# half\n2,4,0\n   \n",
        "t;x;y\n0;0;0\n1,0;2,0;1,0\n2;4;0\n",
        "t\tx\ty\n0\t0\t0\n1\t2\t1\n2\t4\t0\n",
        "t x  y\n0 0 0\n1 2 1\n 2  4  0\n",
        '"t","x","y"\n"0","0","0"\n1,2,1\n2,4,0\n',
        "y,t,x\n0,0,0\n1,1,2\n0,2,4\n",
        "0,0,0\n1,2,1\n2,4,0\n",
    ],
)
def test_one_drawing_in_many_hands(file: Path, tmp_path: Path, content: str) -> None:
    expected = read(tmp_path / "plain.csv", "t,x,y\n0,0,0\n1,2,1\n2,4,0\n")
    assert np.array_equal(read(file, content).coefficients, expected.coefficients)


def test_two_columns_are_a_drawing_without_times(file: Path, tmp_path: Path) -> None:
    named = read(tmp_path / "named.csv", "x,y\n0,0\n2,1\n4,0\n")
    assert np.array_equal(read(file, "0,0\n2,1\n4,0\n").coefficients, named.coefficients)


@pytest.mark.parametrize(
    ("content", "line", "message"),
    [
        ("", 1, "empty"),
        ("# nothing\n\n", 1, "empty"),
        ("t,x,y\n", 1, "at least two points"),
        ("t,x,y\n0,1,1\n", 2, "at least two points"),
        ("t,x,y\n0,0,0\n1,nan,1\n", 3, "nan"),
        ("x,y\n0,0\n\n# so\n1,inf\n", 5, "inf"),
        ("x,y\n0,0\n1,1e300\n", 3, "1e300"),
        ("t,x,y\n0,0,0\n1,1,1\n1,2,2\n", 4, "repeats"),
        ("t,x,y\n0,0,0\n2,1,1\n1,2,2\n", 4, "goes back"),
        ("t,n,e,d\n0,0,0,-2\n0,1,1,-2\n", 3, "repeats"),
        ("t,x,y\n0,0,0\n1,one,1\n", 3, "'one' is not a number"),
        ("0,zero,0\n1,1,1\n", 1, "'zero' is not a number"),
        ("t,x,y\n0,0,0\n1,,1\n", 3, "'' is not a number"),
        ("t,x,y\n0,0,0\n1,1\n", 3, "2 columns where 3"),
        ("x,y\n0,0\n1,1,1\n", 3, "3 columns where 2"),
        ("0,0,0,0\n1,1,1,1\n", 1, "without names"),
        ("0\n1\n", 1, "without names"),
        ("# by me\nt,x,w\n0,0,0\n1,1,1\n", 2, "columns are t,x,w; expected t,n,e,d or"),
        ("x,x\n0,0\n1,1\n", 1, "columns are x,x"),
        (b"x,y\n0,0\n\xff\xfe,1\n", 3, "UTF-8"),
        (b"\x89PNG\r\n\x1a\n\x00\x00", 1, "UTF-8"),
        ("x,y\n0,0\n1,\x000\n", 3, "not a number"),
    ],
)
def test_an_error_names_file_and_line(file: Path, content: str | bytes, line: int, message: str) -> None:
    with pytest.raises(InputError) as caught:
        read(file, content)
    text = str(caught.value)
    assert text.startswith(f"{file}:{line}: ")
    assert message in text
    assert "\n" not in text


@pytest.mark.parametrize(
    ("content", "message"),
    [
        ("x,y\n1,1\n1,1\n", "all points are the same"),
        ("t,x,y,z\n0,0,0,2\n1e6,1,1,2\n", "would take"),
    ],
)
def test_other_errors_name_the_file(file: Path, content: str, message: str) -> None:
    with pytest.raises(InputError, match=message) as caught:
        read(file, content)
    assert str(caught.value).startswith(f"{file}: ")


def test_what_is_no_file_is_refused(tmp_path: Path) -> None:
    for path in (tmp_path, tmp_path / "missing.csv"):
        with pytest.raises(InputError, match="cannot be read"):
            read_trajectory(path, Placement(), Limits())


def test_a_file_that_is_too_large_is_refused(file: Path) -> None:
    with file.open("wb") as sparse:
        sparse.truncate(30_000_000)
    with pytest.raises(InputError, match="larger than 20 MB"):
        read_trajectory(file, Placement(), Limits())


@settings(suppress_health_check=[HealthCheck.function_scoped_fixture], deadline=None)
@given(st.binary(max_size=80) | st.text(alphabet="txyz0123456789.-e,;# \t\r\n", max_size=80))
def test_any_file_is_a_trajectory_or_one_line_of_error(file: Path, content: str | bytes) -> None:
    try:
        trajectory = read(file, content)
    except InputError as error:
        assert "\n" not in str(error)  # noqa: PT017
    else:
        assert np.isfinite(trajectory.coefficients).all()


def test_the_drawings_that_come_along() -> None:
    paths = sorted(DRAWINGS.glob("*.csv"))
    assert [path.stem for path in paths] == ["clef", "signature", "star"]
    for path in paths:
        trajectory = read_trajectory(path, Placement(), Limits())
        assert 8.0 < trajectory.duration_s < 30.0
