"""A flight's inputs from its file: what is none of them is an error in one line."""

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from mcap.reader import make_reader

from companion.errors import InputError
from companion.flight.control import ControlSettings
from companion.flight.differences import Differences
from companion.flight.guard import GuardLimits
from companion.flight.heading import YawMode
from companion.flight.recorded_inputs import Began, Followed, recorded_inputs
from companion.flight.recorder import Recorder
from companion.flight.tracker import PLAIN, Tracker
from companion.recording import topics
from companion.recording.mcap_writer import McapWriter
from companion.recording.series import Provenance
from companion.state import VehicleState
from companion.trajectory.trajectory import quintic_through

SETTINGS = ControlSettings(
    home=(0.1, -0.2, 1e-17), yaw=0.3, yaw_mode=YawMode.PATH, period_s=0.02, limits=GuardLimits()
)
TRAJECTORY = quintic_through(
    "line", 1.5, np.array([[0.0, 0.1, -2.0], [1.0, 1 / 3, -2.0]]), *np.zeros((2, 2, 3))
)
STATE = VehicleState(1.5, 1.52, *(np.array([1 / 3, -0.0, scale]) for scale in (1.0, 2.0, 3.0, 4.0)))


def write(path: Path, topic: str | None = None, **wrong: Any) -> Path:
    """A file with one input of each kind; those of `topic` with wrong fields."""

    class Spoiling(McapWriter):
        def add(self, to: str, time_s: float, fields: topics.Fields) -> None:
            super().add(to, time_s, fields | wrong if to == topic else fields)

    with path.open("wb") as file:
        writer = Spoiling(file, Provenance(vehicle="x"))
        recorder = Recorder(writer)
        recorder.control(1.0, SETTINGS.model_dump_json())
        recorder.follow(1.0, Tracker(TRAJECTORY, 2.0))
        recorder.state(STATE)
        writer.finish()
    return path


def test_inputs_come_back_to_the_bit(tmp_path: Path) -> None:
    began, followed, state = recorded_inputs(write(tmp_path / "flight.mcap"))
    assert isinstance(began, Began)
    assert (began.time_s, began.settings) == (1.0, SETTINGS)
    assert isinstance(followed, Followed)
    assert (followed.start_s, followed.law, followed.trajectory.name) == (2.0, PLAIN, "line")
    assert followed.trajectory.coefficients.tobytes() == TRAJECTORY.coefficients.tobytes()
    assert followed.trajectory.step_s == TRAJECTORY.step_s
    assert isinstance(state, VehicleState)
    assert (state.time_s, state.received_s) == (STATE.time_s, STATE.received_s)
    for name in ("position", "velocity", "attitude", "rates"):
        assert getattr(state, name).tobytes() == getattr(STATE, name).tobytes()


@pytest.mark.parametrize(
    ("topic", "wrong"),
    [
        (topics.CONTROL, {"settings": "{}"}),
        (topics.CONTROL, {"settings": "__import__('os')"}),
        (topics.TRAJECTORY, {"step_s": 0.0}),
        (topics.TRAJECTORY, {"attachment": "another"}),
        (topics.TRAJECTORY, {"start_s": "soon"}),
        (topics.STATE, {"position": {"x": 1.0}}),
        (topics.STATE, {"rates": 3.0}),
        (topics.STATE, {"received_s": [1.0]}),
    ],
)
def test_what_is_no_input_is_an_error(topic: str, wrong: dict[str, Any], tmp_path: Path) -> None:
    path = write(tmp_path / "flight.mcap", topic, **wrong)
    with pytest.raises(InputError, match=r"flight\.mcap: damaged, or of another version") as caught:
        list(recorded_inputs(path))
    assert "\n" not in str(caught.value)


def test_viewers_are_shown_the_path_and_the_vehicle(tmp_path: Path) -> None:
    with write(tmp_path / "flight.mcap").open("rb") as file:
        shown = {
            channel.topic: schema.name for schema, channel, _ in make_reader(file).iter_messages() if schema
        }
    assert shown["/path"] == "foxglove.SceneUpdate"
    assert shown["/pose"] == "foxglove.FrameTransforms"


def test_differences_are_named_by_signal() -> None:
    differences = Differences()
    one = {"u2": {"x": 1.0, "y": 0.0}, "yaw": 0.1, "clips": "a"}
    differences.compare("/tracking", 1.0, one, {"u2": {"x": 1.0, "y": -0.0}, "yaw": 0.1, "clips": "b"})
    assert not differences.found()
    differences.compare("/tracking", 2.0, one, {"u2": {"x": 1.0 + 2**-52, "y": 0.0}, "yaw": 0.1})
    differences.compare("/tracking", 3.0, one, {"u2": {"x": 1.5, "y": 0.0}})
    differences.missing("/guard", 4.0)
    found = [(each.signal, each.first_s, each.count, each.largest) for each in differences.found()]
    assert found == [
        ("/tracking u2.x", 2.0, 2, 0.5),
        ("/tracking yaw", 3.0, 1, math.inf),
        ("/guard", 4.0, 1, math.inf),
    ]
