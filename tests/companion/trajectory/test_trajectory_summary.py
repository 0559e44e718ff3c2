import numpy as np
import pytest

from companion.trajectory.drawing import Drawing, drawing_trajectory
from companion.trajectory.limits import Limits
from companion.trajectory.placement import Placement
from companion.trajectory.summary import summarise


def test_a_line_upwards() -> None:
    line = Drawing("up", np.array([[0.0, 0.0], [0.0, 1.0]]))
    limits = Limits(speed_m_s=0.5)
    summary = summarise(drawing_trajectory(line, Placement(size_m=2.0), limits), limits)
    np.testing.assert_allclose(summary.lowest, [0.0, 0.0, -3.5], atol=1e-6)
    np.testing.assert_allclose(summary.highest, [0.0, 0.0, -1.5], atol=1e-6)
    assert summary.length_m == pytest.approx(2.0, rel=1e-4)
    assert summary.peaks.up_m_s == pytest.approx(0.5)
    assert summary.peaks.down_m_s == pytest.approx(0.0, abs=1e-3)
    assert summary.bound_by == ("speed_m_s",)
    assert summary.lines()[0].startswith("up: 2.00 m in ")
    assert summary.lines()[1] == "box: north 0.00 to 0.00, east 0.00 to 0.00, down -3.50 to -1.50 m"
    assert summary.lines()[-1] == "limit reached: speed_m_s"


def test_a_fast_line_is_bound_by_the_climb() -> None:
    line = Drawing("up", np.array([[0.0, 0.0], [0.0, 1.0]]))
    limits = Limits(speed_m_s=9.0, up_m_s=0.4)
    summary = summarise(drawing_trajectory(line, Placement(), limits), limits)
    assert summary.bound_by == ("up_m_s",)
