"""The report: a page that stands alone, and a picture for everything that it shows."""

import re
import sys
from pathlib import Path

import numpy as np
import pytest

from companion.arrays import Vec3s
from companion.errors import InputError
from companion.experiments.flights import Flight
from companion.experiments.plots import broken, colour_of, plane_of
from companion.experiments.report import write_report

TIME_S = np.linspace(0.0, 5.0, 60)


def flight(trajectory: str, strategy: str, offset_m: float) -> Flight:
    desired = np.column_stack([np.sin(TIME_S), np.zeros(60), -2.0 - np.cos(TIME_S)])
    return Flight(trajectory, strategy, TIME_S, desired, desired + np.array([offset_m, 0.0, 0.0]), offset_m)


def report(flights: list[Flight], directory: Path) -> Path:
    conditions = {"vehicle": "bebop2", "wind": "none & <still>"}
    return write_report(flights, directory, title="A test", conditions=conditions, commands=["scripts/demo"])


def test_page_shows_table_conditions_commands_and_pictures_that_exist(tmp_path: Path) -> None:
    flights = [
        flight("../Über <b>", "baseline", 0.4),
        flight("../Über <b>", "gp", 0.1),
        flight("Wave", "mine", 0.2),
    ]
    page = report(flights, tmp_path / "deep" / "report")
    text = page.read_text(encoding="utf-8")
    for expected in (
        "0.400",
        "−75 %",
        "../Über &lt;b&gt;",
        "none &amp; &lt;still&gt;",
        "scripts/demo",
        "mine",
    ):
        assert expected in text
    assert "<b>" not in text
    pictures = re.findall(r'src="([^"]+)"', text)
    assert len(pictures) == 5
    for picture in pictures:
        assert (page.parent / picture).read_bytes().startswith(b"\x89PNG")
    assert "http" not in text


def test_same_flights_same_bytes(tmp_path: Path) -> None:
    flights = [flight("Wave", "baseline", 0.4)]
    one, two = report(flights, tmp_path / "one").parent, report(flights, tmp_path / "two").parent
    assert sorted(p.name for p in one.iterdir()) == sorted(p.name for p in two.iterdir())
    for picture in one.iterdir():
        assert picture.read_bytes() == (two / picture.name).read_bytes()


def test_without_matplotlib_the_extra_is_named(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delitem(sys.modules, "companion.experiments.plots")
    monkeypatch.delattr("companion.experiments.plots", raising=False)
    monkeypatch.setitem(sys.modules, "matplotlib.axes", None)
    with pytest.raises(InputError, match=r"matplotlib.*extra `bench`"):
        report([flight("Wave", "baseline", 0.4)], tmp_path)


def test_a_place_that_cannot_be_written_is_an_error(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    with pytest.raises(InputError, match="cannot be written"):
        report([flight("Wave", "baseline", 0.4)], tmp_path / "file" / "report")


@pytest.mark.parametrize(
    ("extent", "plane"),
    [([3.0, 0.0, 2.0], (0, 2)), ([0.0, 3.0, 2.0], (1, 2)), ([3.0, 2.0, 0.1], (1, 0))],
)
def test_a_path_is_drawn_in_its_plane(extent: list[float], plane: tuple[int, int]) -> None:
    corner: Vec3s = np.array([[0.0, 0.0, 0.0], extent])
    assert plane_of(corner) == plane


def test_each_strategy_has_its_own_colour() -> None:
    strategies = ("baseline", "feedforward", "lookahead", "dnn", "gp", "dnn+gp")
    assert len({colour_of(strategy) for strategy in strategies}) == len(strategies)


def test_lines_end_where_nothing_is_known() -> None:
    time_s = np.array([0.0, 0.5, 3.0, 3.5, 9.0])
    seen = Flight("Wave", "gp", time_s, np.zeros((5, 3)), np.zeros((5, 3)), 0.0)
    np.testing.assert_array_equal(broken(seen, time_s), [0.0, 0.5, np.nan, 3.0, 3.5, np.nan, 9.0])
    assert broken(seen, seen.flown).shape == (7, 3)


def test_what_was_joined_later_is_drawn_later() -> None:
    points = np.zeros((2, 3))
    assert Flight("Wave", "gp", np.array([7.0, 8.0]), points, points, 0.0).along_s.tolist() == [0.0, 1.0]
    assert Flight("Wave", "gp", np.array([7.0, 8.0]), points, points, 0.0, 5.0).along_s.tolist() == [2.0, 3.0]
