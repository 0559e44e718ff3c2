import subprocess
import sys

import numpy as np
import pytest

from companion.errors import InputError
from companion.experiments import lasa
from companion.experiments.lasa import BENCHMARK_NAMES, TUNING_NAMES, lasa_drawing, lasa_trajectory
from companion.trajectory.limits import Limits, peaks_of
from companion.trajectory.placement import Placement


def test_the_drawings_are_all_there() -> None:
    assert len(BENCHMARK_NAMES) == 10
    assert not set(BENCHMARK_NAMES) & set(TUNING_NAMES)
    for name in BENCHMARK_NAMES + TUNING_NAMES:
        drawing = lasa_drawing(name)
        assert drawing.points.shape == (1000, 2)
        assert drawing.times is not None
        assert (np.diff(drawing.times) > 0.0).all()


@pytest.mark.parametrize("name", BENCHMARK_NAMES)
def test_each_is_flown_at_the_asked_speed(name: str) -> None:
    trajectory = lasa_trajectory(name, Placement(), Limits(speed_m_s=1.2))
    assert peaks_of(trajectory).speed_m_s == pytest.approx(1.2)
    assert 5.0 < trajectory.duration_s < 16.0


def test_an_unknown_shape_is_refused() -> None:
    with pytest.raises(InputError, match=r"'Elephant'.*Angle"):
        lasa_drawing("Elephant")


def test_a_missing_extra_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(lasa, "find_spec", lambda _: None)
    with pytest.raises(InputError, match=r"impromptu\[bench\]"):
        lasa_drawing("Angle")


def test_nothing_is_printed_and_nothing_plotted() -> None:
    code = (
        "import sys; from companion.experiments.lasa import lasa_drawing; lasa_drawing('Angle');"
        "assert 'matplotlib' not in sys.modules"
    )
    done = subprocess.run([sys.executable, "-W", "error", "-c", code], capture_output=True, check=True)
    assert (done.stdout, done.stderr) == (b"", b"")
