"""Whatever a strategy wants, what leaves the guard is finite, near the vehicle and inside the fence."""

import math
import re
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from pydantic import ValidationError

from companion.arrays import Vec3, Vec3s
from companion.errors import InputError
from companion.flight.approach import rest_to_rest
from companion.flight.fence import MARGIN_M, Fence
from companion.flight.guard import Before, Clip, GuardLimits, guard, require_flyable
from companion.flight.reference import Correction, Reference
from companion.state import VehicleState

LIMITS = GuardLimits()
HOME = np.array([1.0, -2.0, 0.5])
ANYTHING = arrays(np.float64, 3, elements=st.floats(allow_nan=True, allow_infinity=True, width=64))
NEARBY = arrays(np.float64, 3, elements=st.floats(-30.0, 30.0))


def _state(position: Vec3) -> VehicleState:
    return VehicleState(0.0, 0.0, position, np.zeros(3), np.zeros(3), np.zeros(3))


@given(ANYTHING, ANYTHING, ANYTHING, NEARBY)
def test_what_leaves_is_always_safe(position: Vec3, velocity: Vec3, u2: Vec3, where: Vec3) -> None:
    plain = Reference(where, np.zeros(3))
    guarded = guard(
        Reference(position, velocity), Correction(u2), plain, state=_state(where), home=HOME, limits=LIMITS
    )
    assert guarded.reference.is_finite()
    low, high = LIMITS.fence.corners()
    assert (guarded.reference.position >= HOME + low).all()
    assert (guarded.reference.position <= HOME + high).all()
    assert math.hypot(*guarded.correction.position) <= LIMITS.correction_m * (1 + 1e-9)
    if Clip.FENCE not in guarded.clips:
        assert math.hypot(*(guarded.reference.position - where)) <= LIMITS.setpoint_distance_m * (1 + 1e-9)


def test_a_modest_reference_passes_unchanged() -> None:
    where = HOME + np.array([0.0, 0.0, -5.0])
    u1 = Reference(where + 0.3, np.ones(3), np.ones(3))
    guarded = guard(u1, Correction(np.full(3, 0.1)), u1, state=_state(where), home=HOME, limits=LIMITS)
    assert guarded.clips == ()
    np.testing.assert_array_equal(guarded.reference.position, where + 0.3 + 0.1)


@pytest.mark.parametrize(
    ("u1", "u2", "clip"),
    [
        (np.zeros(3), np.array([0.0, 1.5, 0.0]), Clip.CORRECTION),
        (np.array([3.0, 0.0, 0.0]), np.zeros(3), Clip.DISTANCE),
        (np.array([0.0, 0.0, 1.8]), np.zeros(3), Clip.FENCE),
        (np.array([np.nan, 0.0, 0.0]), np.zeros(3), Clip.NOT_FINITE),
    ],
)
def test_each_clip_is_named(u1: Vec3, u2: Vec3, clip: Clip) -> None:
    where = HOME + np.array([0.0, 0.0, -2.0])
    wanted = Reference(where + u1, np.zeros(3))
    guarded = guard(
        wanted,
        Correction(u2),
        Reference(where, np.zeros(3)),
        state=_state(where),
        home=HOME,
        limits=LIMITS,
    )
    assert guarded.clips == (clip,)


def test_a_fence_without_inside_is_refused() -> None:
    with pytest.raises(ValidationError, match="below the second"):
        Fence(altitude_m=(3.0, 2.0))


@given(arrays(np.float64, (4, 3), elements=st.floats(-300.0, 300.0)))
def test_a_fence_around_places_holds_them_but_for_the_floor(places: Vec3s) -> None:
    low, high = Fence.around(places).corners()
    assert (places[:, :2] - low[:2] >= MARGIN_M - 1e-9).all()
    assert (high[:2] - places[:, :2] >= MARGIN_M - 1e-9).all()
    assert (places[:, 2] - low[2] >= MARGIN_M - 1e-9).all()
    assert high[2] == Fence().corners()[1][2]


MOTION = GuardLimits(
    speed_m_s=5.0, acceleration_m_s2=6.0, velocity_change_m_s2=20.0, jerk_m_s3=40.0, correction_m_s=2.0
)
STEP_S = 0.02


@given(st.lists(st.tuples(ANYTHING, ANYTHING, ANYTHING), min_size=1, max_size=10))
def test_no_setpoint_moves_or_changes_faster_than_its_limits(wanted: list[tuple[Vec3, Vec3, Vec3]]) -> None:
    where, before = HOME + np.array([0.0, 0.0, -5.0]), None
    still = np.zeros(3)
    for step, (velocity, acceleration, correction) in enumerate(wanted):
        time_s = step * STEP_S
        guarded = guard(
            Reference(where, velocity, acceleration),
            Correction(velocity=correction),
            Reference(where, still),
            state=replace(_state(where), time_s=time_s),
            home=HOME,
            limits=MOTION,
            before=before,
        )
        sent = guarded.reference
        now = still if sent.acceleration is None else sent.acceleration
        assert math.hypot(*guarded.correction.velocity) <= 2.0 + 1e-9
        assert math.hypot(*sent.velocity) <= 5.0 + 1e-9
        assert math.hypot(*now) <= 6.0 + 1e-9
        if before is not None:
            was = still if before.reference.acceleration is None else before.reference.acceleration
            assert math.hypot(*(sent.velocity - before.reference.velocity)) <= 20.0 * STEP_S + 1e-9
            assert math.hypot(*(now - was)) <= 40.0 * STEP_S + 1e-9
        before = Before(time_s, sent)


@pytest.mark.parametrize(
    ("velocity", "acceleration", "clips"),
    [
        (6.0, 0.0, (Clip.SPEED,)),
        (0.0, 7.0, (Clip.ACCELERATION, Clip.JERK)),
        (1.0, 0.0, (Clip.ACCELERATION,)),
        (0.3, 1.0, (Clip.JERK,)),
        (0.3, 0.7, ()),
    ],
)
def test_each_limit_of_motion_is_named(velocity: float, acceleration: float, clips: tuple[Clip, ...]) -> None:
    where, north = HOME + np.array([0.0, 0.0, -5.0]), np.array([1.0, 0.0, 0.0])
    still = Reference(where, north * (4.8 if Clip.SPEED in clips else 0.0))
    guarded = guard(
        Reference(where, velocity * north, acceleration * north),
        *(Correction(), still),
        state=replace(_state(where), time_s=STEP_S),
        home=HOME,
        limits=MOTION,
        before=Before(0.0, still),
    )
    assert guarded.clips == clips


def test_a_reference_without_acceleration_stays_without() -> None:
    where = HOME + np.array([0.0, 0.0, -5.0])
    reference = Reference(where, np.zeros(3))
    guarded = guard(
        *(reference, Correction(), reference),
        state=_state(where),
        home=HOME,
        limits=MOTION,
        before=Before(0.0, reference),
    )
    assert guarded.reference.acceleration is None


@pytest.mark.parametrize(
    ("limits", "what"),
    [
        ({"speed_m_s": 0.9}, "speed_m_s 1.0, and the guard lets 0.9 pass"),
        ({"acceleration_m_s2": 0.2}, "acceleration_m_s2 0.4, and the guard lets 0.2 pass"),
        ({"fence": {"north_m": (-1.0, 3.0)}}, "leaves the fence by 1.00 m"),
        ({"fence": {"circles": [{"radius_m": 3.5}]}}, "0.50 m beyond the guard's fence"),
    ],
)
def test_a_trajectory_that_would_be_clipped_is_refused(limits: dict[str, object], what: str) -> None:
    way = rest_to_rest(np.array([0.0, 0.0, -2.0]), np.array([4.0, 0.0, -2.0]), "way")
    require_flyable(way, LIMITS)
    with pytest.raises(InputError, match=re.escape(what)):
        require_flyable(way, GuardLimits.model_validate(limits))
