import math
from itertools import product

import numpy as np
import pytest

from sitl.arrays import Vec3
from sitl.firmware.px4_parameters import Px4Parameters
from sitl.firmware.px4_position import (
    AttitudeSetpoint,
    PositionGains,
    PositionLimits,
    PositionSetpoint,
    PositionState,
    attitude_setpoint,
    change_hover_thrust,
    control_position,
    limit_thrust,
    position_gains,
    position_setpoint,
    position_state,
    prioritise,
    velocity_setpoint,
)
from sitl.quaternion import from_yaw, to_world, yaw_of
from sitl.vehicle import GRAVITY_M_S2

PARAMETERS = Px4Parameters()
GAINS = position_gains(PARAMETERS)
HOVER = PARAMETERS.MPC_THR_HOVER
LIMITS = PositionLimits(max_up=3.0, max_tilt=math.radians(45.0), min_thrust=0.12, hover_thrust=HOVER)
ORIGIN = np.zeros(3)
LEVEL = np.array((1.0, 0.0, 0.0, 0.0))
DT = 0.01


def setpoint(**channels: tuple[float, ...]) -> PositionSetpoint:
    out = position_setpoint()
    for name, value in channels.items():
        getattr(out, name)[:] = value
    return out


def control(
    wanted: PositionSetpoint,
    *,
    position: Vec3 = ORIGIN,
    velocity: Vec3 = ORIGIN,
    yaw: float = 0.0,
    state: PositionState | None = None,
    limits: PositionLimits = LIMITS,
    gains: PositionGains = GAINS,
    steps: int = 1,
) -> AttitudeSetpoint:
    out = attitude_setpoint()
    state = position_state() if state is None else state
    state.velocity[:] = velocity
    for _ in range(steps):
        control_position(gains, limits, state, wanted, position, velocity, from_yaw(yaw), DT, out)
    return out


def acceleration(out: AttitudeSetpoint) -> Vec3:
    """The acceleration setpoint behind a thrust vector whose tilt was chosen as for level flight."""
    force = to_world(out.attitude, np.array((0.0, 0.0, -out.thrust_and_yaw_rate[0])))
    north, east, down = force * (GRAVITY_M_S2 / HOVER)
    level = GRAVITY_M_S2 / -down
    return np.array((north * level, east * level, down + GRAVITY_M_S2))


def test_hovers_at_its_setpoint() -> None:
    out = control(setpoint(position=(0.0, 0.0, 0.0), heading=(0.0, math.nan)))
    assert out.attitude == pytest.approx((1.0, 0.0, 0.0, 0.0))
    assert out.thrust_and_yaw_rate == pytest.approx((HOVER, 0.0))


def test_cascade_of_position_and_velocity_gains() -> None:
    out = control(setpoint(position=(0.5, -0.25, -0.2)))
    xy = 0.95 * 1.8
    assert acceleration(out) == pytest.approx((0.5 * xy, -0.25 * xy, -0.2 * 1.0 * 4.0))


def test_velocity_and_acceleration_feed_forward_add_up() -> None:
    wanted = setpoint(position=(0.1, 0.0, 0.0), velocity=(0.3, 0.0, 0.0), acceleration=(0.7, 0.1, -0.4))
    expected = (1.8 * (0.95 * 0.1 + 0.3) + 0.7, 0.1, -0.4)
    assert acceleration(control(wanted)) == pytest.approx(expected)


def test_nan_position_leaves_velocity_control() -> None:
    out = control(setpoint(velocity=(1.0, 0.0, 0.0)), position=np.array((50.0, 50.0, 50.0)))
    assert acceleration(out) == pytest.approx((1.8, 0.0, 0.0))


def test_nan_velocity_is_no_feed_forward() -> None:
    with_zero = control(setpoint(position=(0.1, 0.2, 0.3), velocity=(0.0, 0.0, 0.0)))
    without = control(setpoint(position=(0.1, 0.2, 0.3)))
    assert acceleration(without) == pytest.approx(acceleration(with_zero))


def test_acceleration_alone_ignores_position_and_velocity() -> None:
    out = control(setpoint(acceleration=(1.0, -2.0, 0.5)), velocity=np.array((3.0, 3.0, 3.0)))
    assert acceleration(out) == pytest.approx((1.0, -2.0, 0.5))


CHANNELS = ("position", "velocity", "acceleration")
SUBSETS = list(product((False, True), repeat=3))
PAIRS = list(product(SUBSETS, SUBSETS))
WANTED = {"position": (0.4, -0.3, 0.2), "velocity": (0.2, 0.1, -0.3), "acceleration": (0.3, 0.2, -0.5)}
POSITION, VELOCITY = np.array((0.1, 0.1, 0.1)), np.array((-0.2, 0.3, 0.1))


def masked(masks: tuple[tuple[bool, ...], ...]) -> PositionSetpoint:
    """What `WANTED` leaves of each axis; a mask says which of the three channels are given."""
    channels = {
        channel: tuple(
            value if mask[i] else math.nan for value, mask in zip(WANTED[channel], masks, strict=True)
        )
        for i, channel in enumerate(CHANNELS)
    }
    return setpoint(**channels)


def axis_acceleration(axis: int, mask: tuple[bool, ...]) -> float:
    """What a PX4 with default gains asks of an axis that has the channels of `mask`, and at least one."""
    position_p, velocity_p = (0.95, 1.8) if axis < 2 else (1.0, 4.0)
    wanted = 0.0
    if mask[0] or mask[1]:
        speed = position_p * (WANTED["position"][axis] - POSITION[axis]) if mask[0] else 0.0
        speed += WANTED["velocity"][axis] if mask[1] else 0.0
        wanted += velocity_p * (speed - VELOCITY[axis])
    return wanted + (WANTED["acceleration"][axis] if mask[2] else 0.0)


STOPPING = -VELOCITY * (1.8, 1.8, 4.0)


@pytest.mark.parametrize(("horizontal", "vertical"), PAIRS)
def test_any_channels_of_the_horizontal_axes_go_with_any_of_the_vertical_one(
    horizontal: tuple[bool, ...], vertical: tuple[bool, ...]
) -> None:
    masks = (horizontal, horizontal, vertical)
    out = control(masked(masks), position=POSITION, velocity=VELOCITY)
    expected = STOPPING
    if any(horizontal) and any(vertical):
        expected = np.array([axis_acceleration(axis, mask) for axis, mask in enumerate(masks)])
    assert acceleration(out) == pytest.approx(expected)


@pytest.mark.parametrize(("north", "east"), [pair for pair in PAIRS if pair[0] != pair[1]])
def test_north_and_east_that_differ_are_answered_by_stopping(
    north: tuple[bool, ...], east: tuple[bool, ...]
) -> None:
    out = control(masked((north, east, (True, True, True))), position=POSITION, velocity=VELOCITY)
    assert acceleration(out) == pytest.approx(STOPPING)


def test_stopping_keeps_the_present_heading() -> None:
    out = control(setpoint(velocity=(1.0, math.nan, 0.0), heading=(2.0, 0.5)), yaw=-1.0)
    assert yaw_of(out.attitude) == pytest.approx(-1.0)
    assert out.thrust_and_yaw_rate[1] == 0.0


def test_velocity_setpoint_is_limited() -> None:
    far = velocity_setpoint(GAINS, LIMITS, setpoint(position=(100.0, 0.0, -100.0)), ORIGIN)
    assert far == pytest.approx((12.0, 0.0, -3.0))
    below = velocity_setpoint(GAINS, LIMITS, setpoint(position=(0.0, 0.0, 100.0)), ORIGIN)
    assert below[2] == pytest.approx(1.5)


def test_takeoff_ramp_overrules_the_descent_limit() -> None:
    ramp = LIMITS._replace(max_up=-2.4)
    assert velocity_setpoint(GAINS, ramp, setpoint(position=(0.0, 0.0, -5.0)), ORIGIN)[2] == 2.4


@pytest.mark.parametrize(
    ("first", "second", "expected"),
    [
        ((1.0, 0.0), (2.0, 0.0), (3.0, 0.0)),
        ((5.0, 0.0), (0.0, 9.0), (4.0, 0.0)),
        ((3.0, 0.0), (3.0, 0.0), (4.0, 0.0)),
        ((0.0, 0.0), (0.0, -9.0), (0.0, -4.0)),
        ((2.0, 0.0), (0.0, 9.0), (2.0, math.sqrt(12.0))),
    ],
)
def test_position_correction_has_priority_over_feed_forward(
    first: tuple[float, float], second: tuple[float, float], expected: tuple[float, float]
) -> None:
    assert prioritise(np.array(first), np.array(second), 4.0) == pytest.approx(expected)


def test_tilt_is_limited() -> None:
    out = control(setpoint(acceleration=(30.0, 0.0, 0.0)))
    down = to_world(out.attitude, np.array((0.0, 0.0, 1.0)))
    assert math.acos(down[2]) == pytest.approx(math.radians(45.0))
    assert acceleration(out)[2] == pytest.approx(0.0)


@pytest.mark.parametrize(("down", "level_g"), [(0.0, 1.0), (-4.0, 1.4079), (4.0, 0.5921)])
def test_tilt_takes_the_vertical_acceleration_into_account_when_coupled(down: float, level_g: float) -> None:
    gains = position_gains(Px4Parameters(MPC_ACC_DECOUPLE=0))
    out = control(setpoint(acceleration=(2.0, 0.0, down)), gains=gains)
    z = to_world(out.attitude, np.array((0.0, 0.0, 1.0)))
    assert -z[0] / z[2] == pytest.approx(2.0 / (level_g * GRAVITY_M_S2), rel=1e-3)


def test_thrust_never_falls_below_its_minimum() -> None:
    out = control(setpoint(acceleration=(0.0, 0.0, 50.0)))
    assert out.thrust_and_yaw_rate[0] == pytest.approx(LIMITS.min_thrust)


def test_vertical_thrust_comes_first_but_for_the_horizontal_margin() -> None:
    thrust = np.array((0.5, 0.0, -2.0))
    limit_thrust(GAINS, thrust)
    assert thrust == pytest.approx((0.3, 0.0, -math.sqrt(1.0 - 0.3**2)))
    thrust = np.array((0.9, 0.0, -0.8))
    limit_thrust(GAINS, thrust)
    assert thrust == pytest.approx((0.6, 0.0, -0.8))


def test_integral_removes_a_steady_error_and_stops_at_its_limit() -> None:
    state = position_state()
    control(setpoint(velocity=(0.1, 0.0, 0.0)), state=state, steps=100)
    assert state.integral == pytest.approx((0.04, 0.0, 0.0))
    control(setpoint(velocity=(0.0, 0.0, -0.3)), state=state, steps=10_000)
    assert state.integral[2] >= -GRAVITY_M_S2


def test_horizontal_integral_is_forgotten_while_only_acceleration_is_given() -> None:
    state = position_state()
    state.integral[:] = (1.0, -1.0, 0.5)
    wanted = setpoint(acceleration=(0.0, 0.0, math.nan), velocity=(math.nan, math.nan, 0.0))
    out = control(wanted, state=state)
    assert acceleration(out) == pytest.approx((0.0, 0.0, 0.5))
    assert state.integral == pytest.approx((0.0, 0.0, 0.5))


def test_another_hover_thrust_leaves_the_thrust_as_it_is() -> None:
    state = position_state()
    wanted = setpoint(velocity=(0.0, 0.0, -0.5))
    before = control(wanted, state=state, steps=50).thrust_and_yaw_rate[0]
    change_hover_thrust(state, HOVER, 0.4)
    after = control(wanted, state=state, limits=LIMITS._replace(hover_thrust=0.4)).thrust_and_yaw_rate[0]
    integrated = PARAMETERS.MPC_Z_VEL_I_ACC * 0.5 * DT * 0.4 / GRAVITY_M_S2
    assert after == pytest.approx(before + integrated, abs=1e-9)


def test_horizontal_integral_does_not_wind_up_while_the_tilt_is_limited() -> None:
    state = position_state()
    control(setpoint(velocity=(11.0, 0.0, 0.0)), state=state, steps=2000)
    assert abs(state.integral[0]) < 11.0 * 1.8


def test_vertical_integral_stands_still_at_full_and_at_least_thrust() -> None:
    state = position_state()
    control(setpoint(velocity=(0.0, 0.0, 1.5)), velocity=np.array((0.0, 0.0, -8.0)), state=state, steps=500)
    control(setpoint(velocity=(0.0, 0.0, -3.0)), velocity=np.array((0.0, 0.0, 8.0)), state=state, steps=500)
    assert state.integral[2] == 0.0


@pytest.mark.parametrize("yaw", [-3.0, 0.0, 0.4, 2.0])
def test_yaw_setpoint_is_the_heading_and_nan_keeps_the_present_one(yaw: float) -> None:
    tilted = setpoint(acceleration=(1.0, 2.0, 0.0), heading=(yaw, 0.3))
    out = control(tilted)
    nose = to_world(out.attitude, np.array((1.0, 0.0, 0.0)))
    side = to_world(out.attitude, np.array((0.0, 1.0, 0.0)))
    assert nose[0] * math.cos(yaw) + nose[1] * math.sin(yaw) > 0.9
    # The nose lies in the vertical plane of the heading.
    assert -nose[0] * math.sin(yaw) + nose[1] * math.cos(yaw) == pytest.approx(0.0, abs=1e-12)
    assert side @ nose == pytest.approx(0.0, abs=1e-12)
    assert out.thrust_and_yaw_rate[1] == 0.3
    free = control(setpoint(acceleration=(0.0, 0.0, 0.0)), yaw=yaw)
    assert yaw_of(free.attitude) == pytest.approx(yaw)


def test_velocity_derivative_damps_and_is_low_passed() -> None:
    state = position_state()
    out = attitude_setpoint()
    wanted = setpoint(acceleration=(0.0, 0.0, 0.0))
    for step in range(1, 200):
        velocity = np.array((0.5 * step * DT, 0.0, 0.0))
        control_position(GAINS, LIMITS, state, wanted, ORIGIN, velocity, from_yaw(0.0), DT, out)
        if step == 1:
            assert 0.0 < state.acceleration[0] < 0.5 * 0.5
    assert state.acceleration == pytest.approx((0.5, 0.0, 0.0))
    assert state.velocity == pytest.approx(velocity)


def test_velocity_is_low_passed_when_asked() -> None:
    gains = position_gains(Px4Parameters(MPC_VEL_LP=1.0))
    state = position_state()
    velocity = np.array((1.0, 0.0, 0.0))
    wanted = setpoint(velocity=(0.0, 0.0, 0.0))
    for _ in range(round(1.0 / (2.0 * math.pi) / DT)):
        control_position(gains, LIMITS, state, wanted, ORIGIN, velocity, LEVEL, DT, attitude_setpoint())
    assert state.velocity[0] == pytest.approx(1.0 - math.exp(-1.0), abs=0.02)
