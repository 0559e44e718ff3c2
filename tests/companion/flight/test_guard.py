"""Whatever a strategy wants, what leaves the guard is finite, near the vehicle and inside the fence."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from pydantic import ValidationError

from companion.arrays import Vec3, Vec3s
from companion.flight.guard import MARGIN_M, Clip, Fence, GuardLimits, guard
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
