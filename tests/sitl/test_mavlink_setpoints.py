import math
from typing import Any

import numpy as np
import pytest
from pymavlink.dialects.v20 import common as mavlink

from sitl import quaternion
from sitl.mavlink.setpoints import SetpointRefusedError, read_setpoint

LEVEL = np.array([1.0, 0.0, 0.0, 0.0])
VALUES = tuple(float(value) for value in range(1, 12))
OFF = math.nan


def message(mask: int, frame: int = mavlink.MAV_FRAME_LOCAL_NED, values: tuple[float, ...] = VALUES) -> Any:
    return mavlink.MAVLink_set_position_target_local_ned_message(0, 1, 1, frame, mask, *values)


def flat(mask: int, frame: int = mavlink.MAV_FRAME_LOCAL_NED, attitude: Any = LEVEL) -> list[float]:
    setpoint = read_setpoint(message(mask, frame), attitude)
    return [
        *setpoint.position,
        *setpoint.velocity,
        *setpoint.acceleration,
        setpoint.yaw,
        setpoint.yaw_rate,
    ]


P, V, A = [1.0, 2.0, 3.0], [4.0, 5.0, 6.0], [7.0, 8.0, 9.0]
NONE = [OFF] * 3


@pytest.mark.parametrize(
    ("mask", "expected"),
    [
        (0b0000_0000_0000, [*P, *V, *A, 10.0, 11.0]),
        (0b1101_1111_1000, [*P, *NONE, *NONE, OFF, OFF]),  # position
        (0b1101_1100_0111, [*NONE, *V, *NONE, OFF, OFF]),  # velocity
        (0b1100_0011_1111, [*NONE, *NONE, *A, OFF, OFF]),  # acceleration
        (0b1101_1100_0000, [*P, *V, *NONE, OFF, OFF]),
        (0b1100_0000_0000, [*P, *V, *A, OFF, OFF]),
        (0b1001_1100_0000, [*P, *V, *NONE, 10.0, OFF]),
        (0b0101_1100_0000, [*P, *V, *NONE, OFF, 11.0]),
        (0b1101_1110_0011, [OFF, OFF, 3.0, 4.0, 5.0, OFF, *NONE, OFF, OFF]),  # height held, velocity ahead
        (0b1111_1111_1000, [*P, *NONE, *NONE, OFF, OFF]),  # the force bit without acceleration says nothing
    ],
)
def test_each_mask_bit_switches_one_axis_off(mask: int, expected: list[float]) -> None:
    np.testing.assert_array_equal(flat(mask), expected)


def test_values_that_are_not_finite_are_off() -> None:
    values = (1.0, math.nan, 3.0, math.inf, 5.0, -3e38, *VALUES[6:9], math.nan, -math.inf)
    setpoint = read_setpoint(message(0, values=values), LEVEL)
    np.testing.assert_array_equal(setpoint.position, [1.0, OFF, 3.0])
    np.testing.assert_array_equal(setpoint.velocity, [OFF, 5.0, OFF])
    assert math.isnan(setpoint.yaw)
    assert math.isnan(setpoint.yaw_rate)


def test_body_velocity_turns_with_the_heading_and_body_position_is_off() -> None:
    east = quaternion.from_yaw(math.pi / 2)
    values = flat(0b1101_1100_0000, mavlink.MAV_FRAME_BODY_NED, east)
    np.testing.assert_allclose(values[:6], [*NONE, -5.0, 4.0, 6.0], atol=1e-12)


def test_body_acceleration_turns_with_the_whole_attitude() -> None:
    rolled_right = np.array([math.cos(math.pi / 4), math.sin(math.pi / 4), 0.0, 0.0])
    values = flat(0b1100_0011_1111, mavlink.MAV_FRAME_BODY_NED, rolled_right)
    np.testing.assert_allclose(values[6:9], [7.0, -9.0, 8.0], atol=1e-12)


def test_body_velocity_needs_all_three_axes() -> None:
    with pytest.raises(SetpointRefusedError, match="invalid"):
        flat(0b1101_1110_0111, mavlink.MAV_FRAME_BODY_NED)


@pytest.mark.parametrize(
    ("mask", "frame", "reason"),
    [
        (0, mavlink.MAV_FRAME_LOCAL_OFFSET_NED, "coordinate frame 7 unsupported"),
        (0, mavlink.MAV_FRAME_GLOBAL, "coordinate frame 0 unsupported"),
        (0b10_0000_0000, mavlink.MAV_FRAME_LOCAL_NED, "force not supported"),
        (0b1_1111_1111, mavlink.MAV_FRAME_LOCAL_NED, "invalid"),
    ],
)
def test_what_px4_refuses_is_refused_with_its_reason(mask: int, frame: int, reason: str) -> None:
    with pytest.raises(SetpointRefusedError, match=reason):
        flat(mask, frame)
