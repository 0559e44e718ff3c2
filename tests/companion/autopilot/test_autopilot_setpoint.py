import numpy as np
import pytest

from companion.arrays import Vec3
from companion.autopilot.setpoint import position_target
from companion.link.dialect import mavlink

P, V, A = np.array([1.0, 2.0, -3.0]), np.array([0.1, 0.2, 0.3]), np.array([4.0, 5.0, 6.0])
YAW_IGNORED, YAW_RATE_IGNORED = 1024, 2048


@pytest.mark.parametrize(
    ("position", "velocity", "acceleration", "mask"),
    [  # the masks that ArduPilot documents for GUIDED, which PX4 takes as well
        (P, None, None, 3576),
        (None, V, None, 3527),
        (None, None, A, 3135),
        (P, V, None, 3520),
        (P, V, A, 3072),
    ],
)
def test_the_mask_says_what_is_given(
    position: Vec3 | None, velocity: Vec3 | None, acceleration: Vec3 | None, mask: int
) -> None:
    message = position_target((1, 1), 0.0, position, velocity, acceleration, None)
    assert message.type_mask == mask


def test_numbers_are_where_they_belong() -> None:
    message = position_target((7, 1), 12.3456, P, V, A, 0.5)
    assert (message.target_system, message.target_component) == (7, 1)
    assert message.time_boot_ms == 12346
    assert message.coordinate_frame == mavlink.MAV_FRAME_LOCAL_NED
    assert message.type_mask == YAW_RATE_IGNORED
    assert [message.x, message.y, message.z] == P.tolist()
    assert [message.vx, message.vy, message.vz] == V.tolist()
    assert [message.afx, message.afy, message.afz] == A.tolist()
    assert message.yaw == 0.5


def test_a_clock_that_has_run_for_months_still_fits() -> None:
    assert position_target((1, 1), 1e7, P, None, None, None).time_boot_ms == 10**10 % 2**32
