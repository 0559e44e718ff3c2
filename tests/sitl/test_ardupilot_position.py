import math

import numpy as np
import pytest

from sitl.arrays import Vec3
from sitl.firmware.ardupilot_parameters import ArduPilotParameters
from sitl.firmware.ardupilot_path import Path, path
from sitl.firmware.ardupilot_position import (
    PositionState,
    begin_position,
    control_horizontal,
    control_vertical,
    learn_hover,
    position_gains,
    position_state,
)
from sitl.vehicle import GRAVITY_M_S2

DT = 0.0025
GAINS = position_gains(ArduPilotParameters(PSC_VELXY_FLTE=0.0, PSC_VELZ_FLTE=0.0, PSC_ACCZ_FLTE=0.0))
HERE = np.zeros(3)


def start() -> tuple[PositionState, Path]:
    return position_state(0.4), path()


def horizontal(state: PositionState, now: Path, velocity: Vec3 = HERE) -> None:
    control_horizontal(GAINS, state, now, HERE, velocity, DT)


def vertical(state: PositionState, now: Path, measured: float = 0.0, limit: float = 0.0) -> float:
    control_vertical(GAINS, state, now, 0.0, 0.0, measured, limit, DT)
    return float(state.scalars[0])


def test_gains_come_in_si_units() -> None:
    gains = position_gains(ArduPilotParameters())
    assert gains.throttle.p == pytest.approx(0.05)  # of the full throttle for 1 m/s²
    assert gains.velocity.i_max == pytest.approx(10.0)
    assert gains.max_lean == pytest.approx(math.radians(30.0))
    assert position_gains(ArduPilotParameters(PSC_ANGLE_MAX=20.0)).max_lean == pytest.approx(
        math.radians(20.0)
    )


def test_desired_acceleration_is_fed_forward() -> None:
    state, now = start()
    now.acceleration[:] = 1.0, -0.5, 0.0
    horizontal(state, now)
    assert state.wanted[:2] == pytest.approx((1.0, -0.5))
    assert not now.limit.any()


def test_a_position_error_becomes_a_velocity_and_that_an_acceleration() -> None:
    state, now = start()
    state.velocity[0, 0] = 0.3  # the error of the step before, so that there is no derivative
    now.position[0] = 0.3
    horizontal(state, now)
    assert state.wanted[0] == pytest.approx(2.0 * 1.0 * 0.3 + 1.0 * 0.3 * DT)
    assert now.velocity_error[0] == pytest.approx(0.3)


def test_the_path_does_not_run_away_from_the_vehicle() -> None:
    state, now = start()
    now.position[:2] = 3000.0, -4000.0
    horizontal(state, now)
    # 10 m/s may be asked for: 10² / (2 · 2.5) + 2.5 / 2 m off at most.
    assert math.hypot(now.position[0], now.position[1]) == pytest.approx(21.25)
    now.position[2] = 500.0
    vertical(state, now)
    assert now.position[2] == pytest.approx(1.5**2 / 2.0 + 0.5)


def test_lean_is_limited_and_tells_the_path() -> None:
    state, now = start()
    now.acceleration[0] = 9.0
    horizontal(state, now)
    most = GRAVITY_M_S2 * math.tan(math.radians(30.0))
    assert state.wanted[0] == pytest.approx(most)
    assert now.limit[0] == pytest.approx(9.0)
    state.scalars[2] = 0.0  # no thrust to spare: still 10°
    horizontal(state, now)
    assert state.wanted[0] == pytest.approx(GRAVITY_M_S2 * math.tan(math.radians(10.0)))


def test_throttle_is_that_of_hovering_and_less_for_going_down() -> None:
    state, now = start()
    assert vertical(state, now) == pytest.approx(0.4)
    now.acceleration[2] = 1.0
    assert vertical(state, now) == pytest.approx(0.4 - 0.05 - 0.1 * DT)
    assert vertical(state, now, measured=3.0) > 0.4


def test_the_throttle_integral_waits_at_the_limits() -> None:
    state, now = start()
    now.acceleration[2] = 1.0
    vertical(state, now, limit=1.0)
    assert state.throttle[3] == 0.0
    assert now.limit[2] == 1.0


def test_lean_that_keeps_the_height_follows_the_throttle_slowly() -> None:
    state, now = start()
    state.scalars[1] = 0.7
    for _ in range(800):
        vertical(state, now)
    assert math.acos(0.7 / 0.8) < state.scalars[2] < math.radians(50.0)


def test_beginning_keeps_lean_and_throttle() -> None:
    state, now = start()
    state.wanted[:] = 0.7, -0.2, 0.0
    state.scalars[0] = 0.46
    begin_position(GAINS, state, now, np.array((1.0, 2.0, 0.0)), np.array((0.5, 0.0, 0.0)), 0.2)
    control_horizontal(GAINS, state, now, np.array((1.0, 2.0, 0.0)), np.array((0.5, 0.0, 0.0)), DT)
    assert state.wanted[:2] == pytest.approx((0.7, -0.2))
    assert vertical(state, now, measured=0.2) == pytest.approx(0.46)


def test_hover_throttle_is_learnt_slowly_and_within_limits() -> None:
    state, _ = start()
    for _ in range(1000):
        learn_hover(state, 0.5, 0.01, 10.0)
    assert state.scalars[1] == pytest.approx(0.5 - 0.1 * math.exp(-1.0), abs=1e-3)
    for _ in range(10000):
        learn_hover(state, 1.0, 0.01, 10.0)
    assert state.scalars[1] == pytest.approx(0.6875)
