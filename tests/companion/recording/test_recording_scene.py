"""The flight as a 3D scene: its frames, and schemas as Foxglove knows them."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from companion.recording import scene, topics

ANGLES = st.floats(-3.0, 3.0)


@given(roll=ANGLES, pitch=st.floats(-1.5, 1.5), yaw=ANGLES)
def test_the_vehicle_is_turned_as_its_angles_say(roll: float, pitch: float, yaw: float) -> None:
    world, vehicle = scene.pose(0, np.array([1.0, 2.0, -3.0]), np.array([roll, pitch, yaw]))["transforms"]
    assert (world["parent_frame_id"], world["child_frame_id"]) == ("world", "ned")
    assert (vehicle["parent_frame_id"], vehicle["child_frame_id"]) == ("ned", "vehicle")
    turned = Rotation.from_quat([vehicle["rotation"][part] for part in "xyzw"])
    expected = Rotation.from_euler("ZYX", [yaw, pitch, roll])
    np.testing.assert_allclose(turned.as_matrix(), expected.as_matrix(), atol=1e-12)
    up = Rotation.from_quat([world["rotation"][part] for part in "xyzw"]).apply([1.0, 2.0, -3.0])
    np.testing.assert_allclose(up, [1.0, -2.0, 3.0])


def test_a_path_is_one_line_that_takes_the_place_of_another() -> None:
    (entity,) = scene.path(1_500_000_000, np.zeros((5, 3)))["entities"]
    assert entity["id"] == "desired"
    assert entity["timestamp"] == {"sec": 1, "nsec": 500_000_000}
    assert len(entity["lines"][0]["points"]) == 5


def test_every_topic_has_a_schema_that_a_viewer_can_take() -> None:
    for topic in topics.TOPICS:
        schema = topics.json_schema(topic)
        assert schema["type"] == "object"
        assert "time_s" in schema["properties"]
        assert set(schema["required"]) <= set(schema["properties"])
