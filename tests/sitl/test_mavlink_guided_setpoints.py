import math
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from pymavlink.dialects.v20 import common as mavlink

from sitl import quaternion
from sitl.firmware.interface import Estimate, Setpoint
from sitl.mavlink.guided_setpoints import read_guided_setpoint

VALUES = tuple(float(value) for value in range(1, 12))
LOCAL, OFFSET = mavlink.MAV_FRAME_LOCAL_NED, mavlink.MAV_FRAME_LOCAL_OFFSET_NED
BODY, BODY_OFFSET = mavlink.MAV_FRAME_BODY_NED, mavlink.MAV_FRAME_BODY_OFFSET_NED
FACING_EAST = Estimate(
    0.0,
    np.array([10.0, 20.0, -5.0]),
    np.zeros(3),
    np.zeros(3),
    quaternion.from_yaw(math.pi / 2),
    np.zeros(3),
    np.zeros(3),
)
OFF = math.nan
P, V, A, NONE, STILL = [1.0, 2.0, 3.0], [4.0, 5.0, 6.0], [7.0, 8.0, 9.0], [OFF] * 3, [0.0] * 3
POSITION, VELOCITY = 0b1101_1111_1000, 0b1101_1100_0111


def read(mask: int, frame: int = LOCAL, values: tuple[float, ...] = VALUES) -> Setpoint:
    message: Any = mavlink.MAVLink_set_position_target_local_ned_message(0, 1, 1, frame, mask, *values)
    return read_guided_setpoint(message, FACING_EAST)


def flat(setpoint: Setpoint) -> list[float]:
    channels = (setpoint.position, setpoint.velocity, setpoint.acceleration)
    return [*np.concatenate(channels), setpoint.yaw, setpoint.yaw_rate]


@pytest.mark.parametrize(
    ("mask", "expected"),
    [
        (POSITION, [*P, *NONE, *NONE, OFF, OFF]),
        (VELOCITY, [*NONE, *V, *NONE, OFF, OFF]),
        (0b1100_0011_1111, [*NONE, *NONE, *A, OFF, OFF]),
        (0b1101_1100_0000, [*P, *V, *NONE, OFF, OFF]),
        (0b1100_0000_0000, [*P, *V, *A, OFF, OFF]),
        (0b1100_0000_0111, [*NONE, *V, *A, OFF, OFF]),
        (0b1001_1100_0000, [*P, *V, *NONE, 10.0, OFF]),
        (0b0101_1100_0000, [*P, *V, *NONE, OFF, 11.0]),
        (0b1101_1100_0001, [*NONE, *V, *NONE, OFF, OFF]),  # a channel with a masked axis is off
        (0b1111_1100_0000, [*P, *V, *NONE, OFF, OFF]),  # the force bit without acceleration says nothing
    ],
)
def test_channels_count_as_a_whole(mask: int, expected: list[float]) -> None:
    np.testing.assert_array_equal(flat(read(mask)), expected)


@pytest.mark.parametrize(
    ("mask", "frame", "values"),
    [
        (0b1101_1111_1111, LOCAL, VALUES),  # nothing but yaw
        (0b1100_0011_1000, LOCAL, VALUES),  # position and acceleration
        (0b1110_0000_0000, LOCAL, VALUES),  # a force
        (POSITION, mavlink.MAV_FRAME_GLOBAL, VALUES),
        (VELOCITY, LOCAL, (*VALUES[:4], OFF, *VALUES[5:])),
        (VELOCITY, LOCAL, (*VALUES[:4], 1001.0, *VALUES[5:])),
        (POSITION, LOCAL, (math.inf, *VALUES[1:])),
    ],
)
def test_what_guided_does_not_take_stops_the_vehicle(mask: int, frame: int, values: Any) -> None:
    np.testing.assert_array_equal(flat(read(mask, frame, values)), [*NONE, *STILL, *NONE, OFF, OFF])


@pytest.mark.parametrize(
    ("frame", "position", "velocity", "yaw"),
    [
        (LOCAL, [1.0, 2.0, 3.0], V, 10.0),
        (OFFSET, [11.0, 22.0, -2.0], V, 10.0),
        (BODY, [8.0, 21.0, -2.0], [-5.0, 4.0, 6.0], 10.0 + math.pi / 2),
        (BODY_OFFSET, [8.0, 21.0, -2.0], [-5.0, 4.0, 6.0], 10.0 + math.pi / 2),
    ],
)
def test_frames_are_turned_and_moved(
    frame: int, position: list[float], velocity: list[float], yaw: float
) -> None:
    setpoint = read(0b1001_1100_0000, frame)
    np.testing.assert_allclose(setpoint.position, position)
    np.testing.assert_allclose(setpoint.velocity, velocity)
    assert setpoint.yaw == pytest.approx(yaw)


@given(
    st.integers(0, 0xFFFF), st.sampled_from((LOCAL, OFFSET, BODY, 0)), st.tuples(*[st.floats(width=32)] * 11)
)
def test_a_setpoint_is_finite_or_off_whatever_comes(mask: int, frame: int, values: Any) -> None:
    setpoint = read(mask, frame, values)
    for channel in (setpoint.position, setpoint.velocity, setpoint.acceleration):
        assert np.isfinite(channel).all() or np.isnan(channel).all()
    assert not math.isinf(setpoint.yaw)
    assert not math.isinf(setpoint.yaw_rate)
